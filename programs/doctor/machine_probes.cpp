#include "probes.h"

#include <equistream/error.h>
#include <equistream/text.h>
#include <equistream/threads.h>

#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace equistream::doctor {

namespace {

namespace fs = std::filesystem;

/// As instruction sets of Highway are called.
int vector_bits(std::int64_t target) {
    constexpr std::pair<std::string_view, int> families[] = {
        {"AVX3", 512}, {"AVX", 256}, {"SSE", 128}, {"SSSE", 128}, {"NEON", 128}};
    const std::string_view name = hwy::TargetName(target);
    for (const auto& [family, bits] : families)
        if (name.starts_with(family))
            return bits;
    return 0;
}

}  // namespace

Finding probe_processor() {
    // The lowest is the best one. Of those that our loops are compiled for.
    const std::int64_t usable = hwy::SupportedTargets() & (HWY_TARGETS), best = usable & -usable;
    const int bits = vector_bits(best);
    const unsigned threads = usable_processors();
    const std::string vectors = bits > 0 ? std::to_string(bits) + " bits" : "no vectors";
    return Finding::ok(formatted("%s (%s), %u threads", vectors.c_str(), hwy::TargetName(best), threads),
                       {{"vector_bits", bits}, {"instruction_set", hwy::TargetName(best)}, {"threads", threads}});
}

Finding probe_scenes() {
    const char* named = std::getenv("EQUISTREAM_SCENES");
    if (named == nullptr || *named == '\0')
        return {State::missing,
                "EQUISTREAM_SCENES is not set; `equistream scene generate --list` names bundled ones",
                "",
                {}};
    const std::string folder = quotable(named, 300);
    std::vector<std::string> models;
    std::error_code error;
    // Each lies in the folder or in one of its own there.
    constexpr auto skipping = fs::directory_options::skip_permission_denied;
    for (fs::recursive_directory_iterator entry(named, skipping, error), end; !error && entry != end;
         entry.increment(error)) {
        if (entry.depth() > 0)
            entry.disable_recursion_pending();
        if (entry->path().extension() == ".glb")
            models.push_back(entry->path().stem().string());
    }
    if (models.empty())
        return {State::missing, "EQUISTREAM_SCENES=" + folder + " holds no .glb", "", {}};
    std::ranges::sort(models);
    return Finding::ok(folder + ": " + in_a_sentence(models, " and "), {{"folder", named}, {"models", models}});
}

}  // namespace equistream::doctor
