/// An OBJ that is its own MTL: each reader passes over the other's statements.
#include "model_promises.h"
#include "target.h"

#include <scenes/library/model.h>

namespace equistream::fuzz {

namespace {

constexpr std::string_view seed = R"(mtllib model.mtl
newmtl leaf
Kd 0.588 0.588 0.588
Ks 0.1 0.1 0.1
Ns 10
d 0.5
Tr 0.5
illum 4
Tf 1 0.5 1
Ke 1 2 3
map_Kd -s 2 2 1 -clamp on gone.tga
map_d gone.tga
v 0 0 0
v 1 0 0
v 1 1 0 \
v 0 1 0
v 0.5 0.2 0
vn 0 0 1
vt 0.5 0.25
o thing
g a b
usemtl leaf
s 1
f 1/1/1 2//1 3
f -4 -3 -2 -1
s off
usemtl none
f 1 2 3 4 1
)";

void read(Bytes bytes) {
    scratch_file("model.mtl", bytes);
    check_promises(load_model(scratch_file("model.obj", bytes)));
}

Seeds seeds() {
    return {bytes_of(seed)};
}

}  // namespace

const Target obj_target{"obj", read, seeds, 8000};

}  // namespace equistream::fuzz
