#pragma once
/// What libraries of this machine can do. Drivers and runtimes may crash or never return: `equistream-probe NAME` makes
/// one of these in a process of its own. They may throw InputError or WorkError, for what is missing.
#include "finding.h"

#include <array>
#include <string_view>

namespace equistream::doctor {

Finding probe_denoiser();
Finding probe_display();
Finding probe_hardware_decoding();
Finding probe_headset();
Finding probe_opengl();
Finding probe_processor();
Finding probe_scenes();
Finding probe_video();

struct Probe {
    std::string_view name;
    Finding (*find)();
};

inline constexpr std::array probes = {
    Probe{"denoiser", probe_denoiser}, Probe{"display", probe_display}, Probe{"hardware", probe_hardware_decoding},
    Probe{"headset", probe_headset},   Probe{"opengl", probe_opengl},   Probe{"processor", probe_processor},
    Probe{"scenes", probe_scenes},     Probe{"video", probe_video},
};

}  // namespace equistream::doctor
