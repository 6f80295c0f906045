#include "checks.h"

#include <client/transport/congestion.h>
#include <equistream/error.h>
#include <equistream/text.h>
#include <programs/cli/child.h>
#include <programs/cli/commands.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstring>
#include <fstream>
#include <vector>

namespace equistream::doctor {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

std::string last_line(std::string text) {
    while (!text.empty() && text.back() == '\n')
        text.pop_back();
    return text.substr(text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1);
}

/// Why a child did not do what it should have done, in one line.
std::string failure(const cli::ChildEnd& end, double limit_s) {
    if (end.was_too_slow)
        return "no answer within " + in_words(limit_s) + " s";
    const std::string how = end.signal != 0 ? "crashed (" + std::string(strsignal(end.signal)) + ")"
                                            : "failed with status " + std::to_string(end.exit_code);
    const std::string said = last_line(end.errors);
    return quotable(said.empty() ? how : how + ": " + said, 400);
}

Finding probed(std::string_view name, const Surroundings& here) {
    const cli::ChildEnd end =
        cli::run_child({(here.programs / "equistream-probe").string(), std::string(name)}, here.limit_s);
    if (!end.is_good())
        return {State::broken, failure(end, here.limit_s), "", {}};
    return finding_of(ordered_json::parse(last_line(end.output)));
}

// The commands that are Python scripts have a check of their own.

constexpr std::string_view scripts[] = {"study", "fit", "farm"};

Finding find_programs(const Surroundings& here) {
    std::vector<std::string> good, faults;
    for (const cli::Command& command : cli::commands) {
        if (std::ranges::find(scripts, command.name) != std::end(scripts) || command.name == "doctor")
            continue;
        try {
            const cli::ChildEnd end =
                cli::run_child({(here.programs / command.program).string(), "--version"}, here.limit_s);
            if (end.is_good())
                good.emplace_back(command.name);
            else
                faults.push_back(std::string(command.name) + ": " + failure(end, here.limit_s));
        } catch (const WorkError& error) {
            faults.emplace_back(error.what());
        }
    }
    const ordered_json details = {{"start", good}, {"faults", faults}};
    if (!faults.empty())
        return {State::missing, in_a_sentence(faults, "; "), "", details};
    return Finding::ok(in_a_sentence(good, " and ") + " start", details);
}

Finding find_hosts(const Surroundings& here) {
    std::vector<std::string> there;
    std::error_code error;
    for (const cli::Host& host : cli::hosts)
        if (fs::exists(here.programs / host.program, error))
            there.emplace_back(host.name);
    if (there.empty())
        return {State::missing, "no renderer", "", {}};
    return Finding::ok("renderers: " + in_a_sentence(there, " and "), {{"hosts", there}});
}

/// It renders, which takes its wheel, our plugins, and LLVM for the faster variants.
Finding find_mitsuba(const Surroundings& here) {
    constexpr std::string_view name = "mitsuba";
    const cli::Host& host = *std::ranges::find(cli::hosts, name, &cli::Host::name);
    const fs::path program = here.programs / host.program;
    std::error_code error;
    if (!fs::exists(program, error))
        return {State::missing, "this build has no Mitsuba host", std::string(host.how_to_get_it), {}};
    if (host.needs_avx2 && !cli::has_avx2())
        return {State::missing, "this processor has no AVX2", "in a virtual machine: give it the host's CPU model", {}};
    const std::string scene = here.scratch.file("ball.xml");
    std::ofstream(scene) << R"(<scene version="3.0.0"><shape type="sphere"/></scene>)";
    const cli::ChildEnd end = cli::run_child({program.string(), scene, "--out", here.scratch.file("ball"), "--size",
                                              "16x8", "--spp", "1", "--aovs", "depth", "--progress", "none", "--json"},
                                             here.limit_s);
    if (!end.is_good())
        return {State::broken, failure(end, here.limit_s), "", {}};
    const ordered_json report = ordered_json::parse(end.output);
    const std::string variant = report.at("variant");
    Finding finding = Finding::ok("it renders with " + variant, {{"variant", variant}});
    if (end.errors.find("libLLVM") != std::string::npos) {
        finding.found += "; llvm_ad_rgb is faster and needs LLVM";
        finding.get = "sudo apt-get install libllvm19";
    }
    return finding;
}

/// What a server sends by where packets are lost.
Finding find_congestion_control(const Surroundings&) {
    if (!allows_bbr())
        return {State::missing,
                "this system does not allow BBR: packet loss slows streams down, except over srt://",
                "",
                {}};
    return Finding::ok("BBR: packet loss hardly slows streams down");
}

/// `study --packages` says which there are, or how to get them.
Finding find_python(const Surroundings& here) {
    const cli::ChildEnd end =
        cli::run_child({(here.programs / "equistream-study").string(), "--packages"}, here.limit_s);
    if (end.is_good())
        return Finding::ok(last_line(end.output));
    const std::string said = last_line(end.errors), separator = "; to get them: ";
    const std::size_t at = said.find(separator);
    if (at == std::string::npos)
        return {State::missing, failure(end, here.limit_s), "", {}};
    return {State::missing, said.substr(0, at), said.substr(at + separator.size()), {}};
}

constexpr std::array checks = {
    Check{"programs", "every command", true,
          "install equistream's packages, or what `ldd` of the program calls not found; from source: ./demo",
          find_programs},
    Check{"hosts", "render, serve", true, "from source: ./demo", find_hosts},
    Check{"video", "encode, play, view, serve", true, "", nullptr},
    Check{"processor", "every command", false, "", nullptr},
    Check{"opengl", "view, play --depth gl", false, "sudo apt-get install libegl1 libgl1-mesa-dri", nullptr},
    Check{"display", "view", false, "a desktop on X11 or XWayland; without a screen: xvfb-run equistream view ...",
          nullptr},
    Check{"hardware", "view --decode auto", false,
          "sudo apt-get install va-driver-all, or the driver of the GPU's maker", nullptr},
    Check{"headset", "view --headset", false,
          "start the headset's OpenXR runtime (SteamVR, Monado), or name it in XR_RUNTIME_JSON", nullptr},
    Check{"mitsuba", "render --host mitsuba", false,
          "in a virtual environment: pip install " EQUISTREAM_MITSUBA
          ", then add its folders mitsuba and drjit to LD_LIBRARY_PATH",
          find_mitsuba},
    Check{"denoiser", "--denoise of render, serve and import", false,
          "in a virtual environment that is active: pip install pyoidn", nullptr},
    Check{"network", "serve", false, "sudo sysctl net.ipv4.tcp_congestion_control=bbr", find_congestion_control},
    Check{"scenes", "descriptions whose models are not bundled", false,
          "set EQUISTREAM_SCENES to a folder of scenes (.glb)", nullptr},
    Check{"python", "study, fit, farm", false,
          "sudo apt-get install python3; its package equistream: docs/guide/install.md", find_python},
};

}  // namespace

std::span<const Check> all_checks() {
    return checks;
}

Finding found_by(const Check& check, const Surroundings& surroundings) {
    Finding finding;
    try {
        finding = check.find != nullptr ? check.find(surroundings) : probed(check.name, surroundings);
    } catch (const std::exception& error) {
        finding = {State::broken, quotable(error.what(), 400), "", {}};
    }
    finding.found = quotable(finding.found, 600);  // drivers and runtimes call themselves what they like
    if (finding.state != State::ok && finding.get.empty())
        finding.get = check.get;
    return finding;
}

}  // namespace equistream::doctor
