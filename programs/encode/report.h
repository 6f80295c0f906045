#pragma once
/// What encode says of the stream that it made.
#include "encode_sequence.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <string>

namespace equistream {

/// Words of the command line that reports repeat.
struct AsTyped {
    std::string command, codec = "h264", transfer = "srgb", stereo = "tracks";
};

nlohmann::ordered_json encode_json(const EncodeRequest& request, const AsTyped& options, const EncodeReport& report);
/// The same in words.
void print_report(const EncodeRequest& request, const AsTyped& options, const EncodeReport& report, std::FILE* out);

}  // namespace equistream
