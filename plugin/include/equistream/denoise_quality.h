#pragma once
/// Qualities of denoising, and their names in options.
#include <string>
#include <vector>

namespace equistream {

/// In the order of es_denoise; fast, balanced and high are the qualities of Open Image Denoise 2.
enum class DenoiseQuality { off, fast, balanced, high };

inline const std::vector<std::string> denoise_quality_names{"off", "fast", "balanced", "high"};

/// The quality of that name, which must be one of denoise_quality_names.
inline DenoiseQuality denoise_quality(const std::string& name) {
    int quality = 0;
    while (denoise_quality_names.at(static_cast<std::size_t>(quality)) != name)
        ++quality;
    return static_cast<DenoiseQuality>(quality);
}

}  // namespace equistream
