#pragma once
/// How well colour is denoised, as users name it.
#include <string>
#include <vector>

namespace equistream {

/// In the order of es_denoise; all but off are Open Image Denoise's.
enum class DenoiseQuality { off, fast, balanced, high };

inline const std::vector<std::string> denoise_quality_names{"off", "fast", "balanced", "high"};

/// `name` is one of them.
inline DenoiseQuality denoise_quality(const std::string& name) {
    int quality = 0;
    while (denoise_quality_names.at(static_cast<std::size_t>(quality)) != name)
        ++quality;
    return static_cast<DenoiseQuality>(quality);
}

}  // namespace equistream
