#pragma once
/// Which channels of a file are which planes of ours, and why. One table for the person and for the program.
#include "foreign_exr.h"
#include "source_conventions.h"

#include <string>
#include <vector>

namespace equistream::files {

struct MappedPlane {
    std::string plane;                     ///< a name of the AOV catalogue
    std::vector<ForeignChannel> channels;  ///< in the plane's order; three for a depth that is a position
    std::string why;
    int set = 0;  ///< which file of a set they lie in
};

struct LeftOut {
    std::string channels;
    std::string why;
};

struct ChannelMap {
    std::vector<MappedPlane> planes;
    std::vector<LeftOut> left_out;
};

/// "depth=ViewLayer.Depth.Z,normal=ViewLayer.Normal,albedo=none": a layer stands for its channels. Throws InputError.
std::map<std::string, std::vector<std::string>> parse_channels(const std::string& text);

/// The planes of one view in the files of one frame. Throws InputError for a channel that was named and is not there.
ChannelMap map_channels(const std::vector<const ForeignExr*>& files, const std::vector<std::string>& stems,
                        const std::string& view, const SourceConventions& conventions);

}  // namespace equistream::files
