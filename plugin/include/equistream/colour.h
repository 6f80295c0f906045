#pragma once
/// Display transform by OpenColorIO: scene-referred linear Rec.709 <-> display-referred sRGB.
/// The default view is the plain sRGB encoding of exposed, clipped radiance, so that the client can undo it.
/// Objects are immutable after construction; apply and invert may run on any number of threads.
#include <equistream/image.h>

#include <memory>
#include <string>
#include <vector>

namespace equistream {

inline constexpr const char* default_view = "Un-tone-mapped";

class DisplayTransform {
public:
    /// `view` is a view of the bundled OpenColorIO config's sRGB display; throws InputError with the accepted names.
    explicit DisplayTransform(const std::string& view = default_view);
    ~DisplayTransform();
    DisplayTransform(DisplayTransform&&) noexcept;

    /// exposure * linear RGB(A) -> display RGB in [0, 1]. `linear` has 3 or 4 channels, the result 3.
    FloatImage to_display(ImageView<const float> linear, double exposure) const;
    /// The inverse, for display values in [0, 1].
    FloatImage to_linear(ImageView<const float> display, double exposure) const;

private:
    struct Processors;
    std::unique_ptr<Processors> processors_;
};

/// Round to 8 bits: floor(255 x + 1/2), clamped; NaN is 0.
ByteImage quantise_8bit(ImageView<const float> display);
FloatImage widen_8bit(ImageView<const std::uint8_t> display);

// HDR streams and the display, by OpenColorIO: scene-referred linear Rec.709 to R'G'B' of SMPTE ST 2084 ("PQ",
// Rec.2100: BT.2020 primaries) before coding, and from there to a display at the client.

/// Nits of radiance 1 after exposure: BT.2408's reference white. PQ ends at 10,000, so highlights up to 49 times that
/// are kept.
inline constexpr double pq_white_nits = 203;

/// exposure * linear RGB(A) -> PQ R'G'B' in [0, 1], 3 channels. Immutable; any number of threads.
class PqEncoding {
public:
    PqEncoding();
    ~PqEncoding();
    FloatImage encode(ImageView<const float> linear, double exposure) const;

private:
    struct Processor;
    std::unique_ptr<Processor> processor_;
};

/// Which display, and how light is brought into its range.
struct HdrDisplaySettings {
    std::string config;         ///< file of an OpenColorIO config; empty: the one that is compiled in
    std::string display;        ///< of the config; empty: "sRGB - Display" of ours, of others their default
    std::string view;           ///< of the display; empty: default_view of ours, of others the display's default
    double exposure_stops = 0;  ///< before the view; -20 to 20
};

/// A table that a shader reads, 3 channels a texel or 1, 32-bit floats, clamped at its edges.
struct ShaderTable {
    std::string sampler;
    int width = 0, height = 0, depth = 0;  ///< height 0: one-dimensional; depth 0: no volume
    int channels = 3;
    bool linear = true;  ///< how it is interpolated
    std::vector<float> values;
};

/// GLSL 4.0: `vec4 pq_to_display(vec4)` and all it needs, whatever stage it stands in.
struct DisplayShader {
    static constexpr const char* function = "pq_to_display";
    std::string text;
    std::string exposure_uniform;  ///< a float, in stops
    std::vector<ShaderTable> tables;
};

/// PQ R'G'B' to a display's values in [0, 1]. Immutable; any number of threads.
class HdrDisplay {
public:
    /// Throws InputError with the accepted names, or for a config that cannot be read or does not say how its colours
    /// relate to others' (the role aces_interchange).
    explicit HdrDisplay(const HdrDisplaySettings& settings = {});
    ~HdrDisplay();
    HdrDisplay(const HdrDisplay&) = delete;
    HdrDisplay& operator=(const HdrDisplay&) = delete;

    const HdrDisplaySettings& settings() const { return settings_; }  ///< with the names that were chosen
    /// 3 channels.
    FloatImage to_display(ImageView<const float> pq) const;
    /// The same with the exposure left to its uniform.
    DisplayShader shader() const;

private:
    struct Transforms;
    HdrDisplaySettings settings_;
    std::unique_ptr<Transforms> transforms_;
};

inline constexpr double max_exposure_stops = 20;

}  // namespace equistream
