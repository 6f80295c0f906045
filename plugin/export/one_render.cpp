#include "frame_json.h"

#include <equistream/error.h>
#include <equistream/formatted.h>
#include <equistream/sequence.h>

#include <vector>

namespace equistream {
namespace {

struct Setting {
    std::string in_full;  // with its name
    std::string value;
};

/// In an order that tells the plainest difference first.
std::vector<Setting> settings_of(const FrameInfo& info) {
    const std::string size = size_text(width_of(info.camera), height_of(info.camera));
    const std::string samples = std::to_string(info.samples_per_pixel), seed = std::to_string(info.seed);
    const std::string camera = camera_to_json(info.camera).dump(), host = "\"" + info.host + "\"";
    const std::string patches = info.patches ? patches_to_json(*info.patches).dump() : "none";
    return {{size + " pixels", size}, {"camera " + camera, camera}, {"spp " + samples, samples},
            {"seed " + seed, seed},   {"host " + host, host},       {"patches " + patches, patches}};
}

}  // namespace

OneRender::OneRender(const std::filesystem::path& folder) {
    const std::filesystem::path manifest = folder / "manifest.json";
    if (!std::filesystem::exists(manifest))
        return;
    expected_ = read_manifest(folder).shared;
    as_in_ = manifest.string();
}

void OneRender::require(const std::filesystem::path& file, const FrameInfo& info) {
    if (!expected_)
        expected_ = info;
    const std::vector<Setting> expected = settings_of(*expected_), found = settings_of(info);
    for (std::size_t i = 0; i < expected.size(); ++i)
        if (expected[i].value != found[i].value)
            throw InputError(expected_found(file.string(), expected[i].in_full + " as in " + as_in_, found[i].value));
}

}  // namespace equistream
