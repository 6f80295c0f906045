#pragma once
/// Checks what a host hands over, field by field; every complaint names the field, what was expected and what was
/// found.
#include <equistream/equistream.h>
#include <equistream/sequence.h>

#include <filesystem>
#include <optional>
#include <string>

namespace equistream {

struct SequenceSettings {
    std::filesystem::path folder;
    Manifest manifest;  ///< all that frames share; the fingerprint covers every setting that decides pixels
    bool overwrite = false;
    bool single_part = false;
};

/// Throws InputError.
SequenceSettings checked_settings(const es_sequence_settings* settings);

struct FrameSettings {
    std::int64_t index = 0;
    double time_s = 0;
    Pose head_previous, head, head_next;
};

/// Throws InputError.
FrameSettings checked_settings(const es_frame_settings* settings);

/// How two manifests differ in what decides pixels or the files' layout: "expected spp 16, found 64"; nothing if they
/// agree.
std::optional<std::string> difference(const Manifest& expected, const Manifest& found);

}  // namespace equistream
