#include "independent_runs.h"

#include <equistream/error.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <functional>
#include <utility>

namespace equistream {

namespace {

namespace fs = std::filesystem;

/// What decided the noise.
struct Sampling {
    std::uint64_t seed = 0;
    std::uint32_t samples_per_pixel = 0;
};

/// What `play` wrote of its source; nothing where it did not, or where the file is somebody else's.
std::optional<Sampling> sampling_of_views(const fs::path& view) {
    std::ifstream file(fs::absolute(view).parent_path().parent_path() / "report.json");
    const auto report = nlohmann::json::parse(file, nullptr, false);
    const auto source = report.is_object() ? report.find("source") : report.end();
    if (source == report.end() || !source->is_object())
        return std::nullopt;
    const auto seed = source->find("seed");
    const auto samples = source->find("samples_per_pixel");
    if (seed == source->end() || samples == source->end() || !seed->is_number_unsigned() ||
        !samples->is_number_unsigned())
        return std::nullopt;
    return Sampling{seed->get<std::uint64_t>(), samples->get<std::uint32_t>()};
}

std::optional<Sampling> sampling_of(const ScoredPicture& picture) {
    if (!picture.info)
        return sampling_of_views(picture.file);
    if (picture.info->samples_per_pixel == 0)
        return std::nullopt;  // a foreign file
    return Sampling{picture.info->seed, picture.info->samples_per_pixel};
}

/// The same samples, and not one value throughout.
template <typename Sample>
bool same_samples(const Image<Sample>& a, const Image<Sample>& b) {
    const auto first = a.samples();
    const auto second = b.samples();
    const bool constant = std::ranges::adjacent_find(first, std::not_equal_to<>()) == first.end();
    return !constant && std::ranges::equal(first, second);
}

bool same_noise(const ScoredPicture& a, const ScoredPicture& b) {
    return a.linear == b.linear && (a.linear ? same_samples(a.radiance, b.radiance) : same_samples(a.rgb, b.rgb));
}

[[noreturn]] void refuse(const fs::path& file, const std::string& expected, const std::string& found) {
    throw InputError(expected_found("--second: " + file.string(), expected, found));
}

}  // namespace

void require_other_files(const PicturePair& pair) {
    for (const fs::path& first : {pair.picture, pair.truth})
        for (const fs::path& second : {pair.second_picture, pair.second_truth}) {
            std::error_code ignored;  // what is missing is told when it is read
            if (first == second || fs::equivalent(first, second, ignored))
                refuse(second, "a run that shares no picture with the first", "the file " + first.string());
        }
}

void require_independent(const RunPictures& run_1, const RunPictures& run_2) {
    for (const ScoredPicture* first : {&run_1.picture, &run_1.truth})
        for (const ScoredPicture* second : {&run_2.picture, &run_2.truth}) {
            if (same_noise(*first, *second))
                refuse(second->file, "a run with noise of its own", "the contents of " + first->file.string());
            const auto a = sampling_of(*first);
            const auto b = sampling_of(*second);
            if (a && b && a->seed == b->seed)
                refuse(second->file, "a run with another seed than the first",
                       "seed " + std::to_string(b->seed) + ", that of " + first->file.string());
        }
    for (const auto& [first, second] : {std::pair{&run_1.picture, &run_2.picture}, {&run_1.truth, &run_2.truth}}) {
        const auto a = sampling_of(*first);
        const auto b = sampling_of(*second);
        if (a && b && a->samples_per_pixel != b->samples_per_pixel)
            refuse(second->file,
                   "the " + std::to_string(a->samples_per_pixel) + " samples per pixel of " + first->file.string(),
                   std::to_string(b->samples_per_pixel));
    }
}

}  // namespace equistream
