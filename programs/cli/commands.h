#pragma once
/// What `equistream COMMAND` runs, and whose options a section [COMMAND] of a settings file may hold.
#include <equistream/error.h>
#include <equistream/text.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

namespace equistream::cli {

struct Command {
    std::string_view name;
    std::string_view program;  ///< beside the dispatcher
    std::string_view summary;
};

inline constexpr std::array commands = {
    Command{"render", "equistream-render-embree", "path trace a scene along a path: EXR sequences with AOVs"},
    Command{"encode", "equistream-encode", "code a rendered sequence as video that carries its poses"},
    Command{"serve", "equistream-serve", "send a recorded stream, or a scene as it is rendered, to viewers"},
    Command{"play", "equistream-play", "decode, reproject to both eyes, fill gaps, write views"},
    Command{"view", "equistream-view", "look around in a stream, in a window"},
    Command{"compare", "equistream-compare", "score views against the truth: PSNR, SSIM, whole and noise-free error"},
    Command{"import", "equistream-import", "make frames of any renderer's EXR sequences"},
    Command{"export", "equistream-export",
            "write frames as EXR files that compositing programs read: deep, or in parts"},
    Command{"info", "equistream-info", "explain a stream, a frame or a folder"},
    Command{"model", "equistream-model", "make the geometry a client needs of a scene"},
    Command{"scene", "equistream-scene", "generate bundled scenes, describe a scene"},
    Command{"farm", "equistream-farm", "divide a render, an encode or a study among the machines of a farm"},
    Command{"study", "equistream-study", "speed against accuracy of every method, on real scenes or bundled ones"},
    Command{"fit", "equistream-fit", "find the cheapest settings for a wanted accuracy"},
    Command{"doctor", "equistream-doctor", "say what is installed, what is missing and how to get it"},
};

// The known word that a mistyped one was probably meant to be.

/// How many letters must be put in, left out, replaced or swapped with their neighbour to turn one word into the other.
inline std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> before(b.size() + 1), row(b.size() + 1), next(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        next[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            next[j] = std::min({row[j] + 1, next[j - 1] + 1, row[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                next[j] = std::min(next[j], before[j - 2] + 1);
        }
        before = row;
        row = next;
    }
    return row.back();
}

/// The nearest of `known`, or an empty word where none is near: one letter in three may differ, and what begins with
/// the whole word is near.
template <typename Words>
std::string nearest_word(std::string_view word, const Words& known) {
    std::string nearest;
    std::size_t least = word.size() / 3 + 1;
    for (const auto& each : known) {
        const std::string_view candidate = each;
        const bool is_begun = word.size() >= 3 && candidate.starts_with(word);
        const std::size_t distance = is_begun ? 1 : edit_distance(word, candidate);
        if (distance < least) {
            least = distance;
            nearest = candidate;
        }
    }
    return nearest;
}

/// "; did you mean NAME?", or nothing where no known word is near.
template <typename Words>
std::string did_you_mean(std::string_view word, const Words& known) {
    const std::string nearest = nearest_word(word, known);
    return nearest.empty() ? "" : "; did you mean " + nearest + "?";
}

// The hosts table: what `--host` of render and serve may name. A new host is one row.

struct Host {
    std::string_view name;
    std::string_view program;        ///< beside the dispatcher
    std::string_view how_to_get_it;  ///< said where this build does not have it
    bool needs_avx2 = false;         ///< its libraries would end by SIGILL without a word
};

/// A processor that has it has all else that those libraries use.
inline bool has_avx2() {
#if defined(__x86_64__)
    return __builtin_cpu_supports("avx2") != 0;
#else
    return false;
#endif
}

/// The first is the default.
inline constexpr std::array hosts = {
    Host{"embree", "equistream-render-embree", "configure with it and build"},
    Host{"mitsuba", "equistream-render-mitsuba",
         "build the target programs; without build/venv first pip install mitsuba==3.9.1 nanobind==2.14.0 and "
         "configure again (docs/mitsuba.md)",
         true},
};

/// "embree or mitsuba".
inline std::string host_names() {
    std::array<std::string_view, hosts.size()> names;
    std::ranges::transform(hosts, names.begin(), &Host::name);
    return in_a_sentence(names, " or ");
}

/// The program of a host. Throws InputError for what is none, where this build does not have it, and where this
/// machine's processor cannot run it.
inline std::filesystem::path host_program(const std::string& name, const std::filesystem::path& folder,
                                          bool avx2_is_there = has_avx2()) {
    const auto host = std::ranges::find(hosts, name, &Host::name);
    if (host == hosts.end())
        throw InputError(expected_found("--host", host_names(), "'" + name + "'"));
    std::filesystem::path program = folder / host->program;
    std::error_code error;
    if (!std::filesystem::exists(program, error))
        throw InputError(
            expected_found("--host " + name, program.string(), "none; to get it: " + std::string(host->how_to_get_it)));
    if (host->needs_avx2 && !avx2_is_there)
        throw InputError(expected_found("--host " + name, "a processor with AVX2",
                                        "one without (a virtual machine needs the host's CPU model); --host " +
                                            std::string(hosts.front().name) + " needs none"));
    return program;
}

}  // namespace equistream::cli
