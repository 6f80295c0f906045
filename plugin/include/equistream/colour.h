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

    /// exposure * linear RGB(A) -> display RGB in [0, 1]. `linear` has 3 or 4 channels, the result 3. NaN counts as 0.
    /// Throws InputError unless the exposure is a finite factor above 0.
    FloatImage to_display(ImageView<const float> linear, double exposure) const;
    /// The inverse: display RGB in [0, 1] to linear radiance, divided by the exposure.
    FloatImage to_linear(ImageView<const float> display, double exposure) const;

private:
    struct Processors;
    std::unique_ptr<Processors> processors_;
};

/// Display values to 8 bits: floor(255 x + 1/2), clamped; NaN is 0.
ByteImage quantise_8bit(ImageView<const float> display);
/// 8 bits to display values: x / 255.
FloatImage widen_8bit(ImageView<const std::uint8_t> display);

// HDR streams and the display, by OpenColorIO: scene-referred linear Rec.709 to R'G'B' of SMPTE ST 2084 ("PQ",
// Rec.2100: BT.2020 primaries) before coding, and from there to a display at the client.

/// Luminance, in cd/m^2 (nits), of radiance 1 after exposure: the reference white of ITU-R BT.2408. PQ ends at 10,000
/// cd/m^2, so highlights up to 49 times as bright are kept.
inline constexpr double pq_white_nits = 203;

/// Encodes radiance for HDR streams. Immutable; any number of threads.
class PqEncoding {
public:
    PqEncoding();
    ~PqEncoding();
    /// exposure * linear RGB(A) -> PQ R'G'B' in [0, 1], 3 channels.
    FloatImage encode(ImageView<const float> linear, double exposure) const;

private:
    struct Processor;
    std::unique_ptr<Processor> processor_;
};

/// The display, and the view that maps scene light to its range.
struct HdrDisplaySettings {
    std::string config;         ///< file of an OpenColorIO config; empty: the bundled config
    std::string display;        ///< in that config; empty: "sRGB - Display" in the bundled one, else its default
    std::string view;           ///< of that display; empty: default_view for the bundled default, else the display's
    double exposure_stops = 0;  ///< applied before the view; -20 to 20
};

/// A lookup table of a shader: 32-bit floats, clamped at its edges.
struct ShaderTable {
    std::string sampler;                   ///< name in the shader's text
    int width = 0, height = 0, depth = 0;  ///< height 0: one-dimensional; depth 0: no volume
    int channels = 3;                      ///< a texel: 3 or 1
    bool linear = true;                    ///< false: the nearest texel, without interpolation
    std::vector<float> values;             ///< in the order of glTexImage; channels interleaved
};

/// GLSL 4.0 source of `vec4 pq_to_display(vec4)` with everything it calls, for any shader stage.
struct DisplayShader {
    static constexpr const char* function = "pq_to_display";
    std::string text;
    std::string exposure_uniform;  ///< a float, in stops
    std::vector<ShaderTable> tables;
};

/// Converts decoded HDR pictures for a display. Immutable; any number of threads.
class HdrDisplay {
public:
    /// Throws InputError for an unknown display or view, naming the accepted ones, and for an exposure out of range.
    /// Also for a config that cannot be read, or lacks the roles scene_linear and aces_interchange.
    explicit HdrDisplay(const HdrDisplaySettings& settings = {});
    ~HdrDisplay();
    HdrDisplay(const HdrDisplay&) = delete;
    HdrDisplay& operator=(const HdrDisplay&) = delete;

    const HdrDisplaySettings& settings() const { return settings_; }  ///< with the display and view in use
    /// PQ R'G'B' -> display R'G'B', both in [0, 1]. `pq` has 3 or 4 channels, the result 3.
    FloatImage to_display(ImageView<const float> pq) const;
    /// The same conversion as a shader; the caller sets the exposure by the shader's uniform.
    DisplayShader shader() const;

private:
    struct Transforms;
    HdrDisplaySettings settings_;
    std::unique_ptr<Transforms> transforms_;
};

inline constexpr double max_exposure_stops = 20;

}  // namespace equistream
