/// A camera or head path (CSV).
#include "target.h"

#include <scenes/library/scene.h>

#include <cmath>

namespace equistream::fuzz {

namespace {

void read(Bytes bytes) {
    const PosePath path = read_path_csv(scratch_file("path.csv", bytes));
    require(!path.empty(), "there is a key");
    const double first = path.keys().front().time_s;
    for (const double time_s : {first - 1, first, 0.5 * (first + path.duration_s()), path.duration_s() + 1}) {
        const Pose pose = path.at(time_s);
        require(std::isfinite(pose.position_m.x) && std::abs(glm::length(pose.orientation) - 1) < 1e-6,
                "every pose between is a pose");
    }
}

Seeds seeds() {
    return {bytes_of("\xef\xbb\xbf# recorded\r\ntime_s,x,y,z,qw,qx,qy,qz\r\n\r\n0, 1,2,3, 1,0,0,0\r\n"
                     "+1,4,5,6,0,1,0,0\r\n2.5,-1e-3,5.25,6,0.6,0,0.8,0"),
            bytes_of("0,0,0,0,1,0,0,0\n")};
}

}  // namespace

const Target path_target{"path", read, seeds, 20000};

}  // namespace equistream::fuzz
