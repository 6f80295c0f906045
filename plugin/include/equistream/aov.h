#pragma once
/// The AOV catalogue: every plane a frame can carry, its channels, unit and meaning, in one table. C++17-clean, nothing
/// to link with. Geometry planes come from one unfiltered sample along the pixel-centre ray.
#include <cstddef>
#include <optional>
#include <string_view>

namespace equistream {

enum class SampleType { half, real, id };  ///< as stored in EXR: 16-bit half, 32-bit float, 32-bit unsigned

/// View of a static array, which it does not own.
template <typename Entry>
class TableView {
public:
    template <std::size_t count>
    constexpr TableView(const Entry (&entries)[count]) : entries_(entries), count_(count) {}

    constexpr const Entry* begin() const { return entries_; }
    constexpr const Entry* end() const { return entries_ + count_; }
    constexpr std::size_t size() const { return count_; }
    constexpr const Entry& operator[](std::size_t i) const { return entries_[i]; }

private:
    const Entry* entries_;
    std::size_t count_;
};

struct AovInfo {
    std::string_view name;                 ///< the plane's name in a Frame
    std::string_view group;                ///< name in --aovs and es_sequence_settings.aovs; planes may share a group
    TableView<std::string_view> channels;  ///< EXR channel names, in the plane's sample order
    SampleType type;                       ///< of the EXR channels; in memory half is a 32-bit float too
    bool data_part;                        ///< in EXR part "data" rather than "rgba"
    std::string_view unit;                 ///< "1": dimensionless; "": a number without a unit, such as an id
    std::string_view meaning;              ///< one line for people
    bool in_all = true;                    ///< false: group "all" leaves it out, its own group has to be named
};

namespace aov_channels {
inline constexpr std::string_view colour[] = {"R", "G", "B", "A"};
inline constexpr std::string_view albedo[] = {"albedo.R", "albedo.G", "albedo.B"};
inline constexpr std::string_view depth[] = {"depth.Z"};
inline constexpr std::string_view backward[] = {"backward.u", "backward.v"};
inline constexpr std::string_view forward[] = {"forward.u", "forward.v"};
inline constexpr std::string_view normal[] = {"normal.X", "normal.Y", "normal.Z"};
inline constexpr std::string_view object_id[] = {"object_id"};
inline constexpr std::string_view material_id[] = {"material_id"};
inline constexpr std::string_view instance_id[] = {"instance_id"};
inline constexpr std::string_view specular[] = {"specular"};
inline constexpr std::string_view virtual_depth[] = {"virtual_depth.Z"};
inline constexpr std::string_view virtual_backward[] = {"virtual_backward.u", "virtual_backward.v"};
inline constexpr std::string_view virtual_forward[] = {"virtual_forward.u", "virtual_forward.v"};
inline constexpr std::string_view guide_albedo[] = {"guide_albedo.R", "guide_albedo.G", "guide_albedo.B"};
inline constexpr std::string_view guide_normal[] = {"guide_normal.X", "guide_normal.Y", "guide_normal.Z"};
inline constexpr std::string_view raw[] = {"raw.R", "raw.G", "raw.B"};
inline constexpr std::string_view samples[] = {"samples"};
inline constexpr std::string_view variance[] = {"variance"};
inline constexpr std::string_view reference[] = {"reference.R", "reference.G", "reference.B", "reference.A"};
inline constexpr std::string_view reference_repeat[] = {"reference_repeat.R", "reference_repeat.G",
                                                        "reference_repeat.B"};
inline constexpr std::string_view crypto_object[] = {"CryptoObject00.r", "CryptoObject00.g", "CryptoObject00.b",
                                                     "CryptoObject00.a", "CryptoObject01.r", "CryptoObject01.g",
                                                     "CryptoObject01.b", "CryptoObject01.a", "CryptoObject02.r",
                                                     "CryptoObject02.g", "CryptoObject02.b", "CryptoObject02.a"};
inline constexpr std::string_view crypto_material[] = {
    "CryptoMaterial00.r", "CryptoMaterial00.g", "CryptoMaterial00.b", "CryptoMaterial00.a",
    "CryptoMaterial01.r", "CryptoMaterial01.g", "CryptoMaterial01.b", "CryptoMaterial01.a",
    "CryptoMaterial02.r", "CryptoMaterial02.g", "CryptoMaterial02.b", "CryptoMaterial02.a"};
}  // namespace aov_channels

inline constexpr AovInfo aov_table[] = {
    {"colour", "colour", aov_channels::colour, SampleType::half, false, "radiance",
     "scene-referred linear Rec.709; A is the fraction of samples that hit a surface"},
    {"albedo", "albedo", aov_channels::albedo, SampleType::half, false, "1",
     "diffuse albedo, specular colour of a metal; 0 for a miss"},
    {"depth", "depth", aov_channels::depth, SampleType::real, true, "m",
     "distance from the camera's centre to the nearest surface along the pixel-centre ray; +inf for a miss"},
    {"backward", "motion", aov_channels::backward, SampleType::real, true, "pixel",
     "from this pixel to where the point was in the previous frame"},
    {"forward", "motion", aov_channels::forward, SampleType::real, true, "pixel",
     "from this pixel to where the point will be in the next frame"},
    {"normal", "normal", aov_channels::normal, SampleType::real, true, "1",
     "world space, unit, facing the camera; 0 for a miss"},
    {"object_id", "ids", aov_channels::object_id, SampleType::id, true, "", "from 1; 0 for a miss"},
    {"material_id", "ids", aov_channels::material_id, SampleType::id, true, "", "from 1; 0 for a miss"},
    {"instance_id", "ids", aov_channels::instance_id, SampleType::id, true, "", "from 1; 0 for a miss"},
    {"specular", "specular", aov_channels::specular, SampleType::real, true, "",
     "1 where over 3/4 of what the surface sends on leaves as a sharp reflection or refraction, else 0"},
    {"virtual_depth", "virtual", aov_channels::virtual_depth, SampleType::real, true, "m",
     "distance along the pixel-centre ray at which a sharp reflection or refraction appears to lie; +inf for one "
     "without end; depth elsewhere"},
    {"virtual_backward", "virtual", aov_channels::virtual_backward, SampleType::real, true, "pixel",
     "from this pixel to where what appears in it was in the previous frame"},
    {"virtual_forward", "virtual", aov_channels::virtual_forward, SampleType::real, true, "pixel",
     "from this pixel to where what appears in it will be in the next frame"},
    {"guide_albedo", "guides", aov_channels::guide_albedo, SampleType::half, true, "1",
     "mean over the colour samples of the albedo of the first rough surface that each met, through mirrors and glass; "
     "of lamps and sky their radiance, at most 1",
     false},
    {"guide_normal", "guides", aov_channels::guide_normal, SampleType::half, true, "1",
     "mean of those surfaces' normals, world space; 0 for the sky", false},
    {"raw", "raw", aov_channels::raw, SampleType::half, true, "radiance", "colour as it was before it was denoised",
     false},
    {"samples", "samples", aov_channels::samples, SampleType::real, true, "",
     "independent colour samples that the mean over this frame and earlier ones is worth", false},
    {"variance", "variance", aov_channels::variance, SampleType::real, true, "radiance^2",
     "of that mean's luminance, as estimated; of no meaning where samples is 0", false},
    {"reference", "reference", aov_channels::reference, SampleType::half, true, "radiance",
     "colour by many more samples at a few pixels, where A is 1; 0 elsewhere", false},
    {"reference_repeat", "reference", aov_channels::reference_repeat, SampleType::half, true, "radiance",
     "the same by as many samples of its own: where both differ, it is noise", false},
    {"crypto_object", "cryptomatte", aov_channels::crypto_object, SampleType::real, true, "",
     "Cryptomatte of objects: ids by name and how much of the pixel's colour samples each covers, six of each at most",
     false},
    {"crypto_material", "cryptomatte", aov_channels::crypto_material, SampleType::real, true, "",
     "the same of materials", false},
};

/// All planes, colour first.
constexpr TableView<AovInfo> aov_catalogue() {
    return aov_table;
}

/// The entry with this plane name; nullopt for an unknown name.
constexpr std::optional<AovInfo> find_aov(std::string_view name) {
    for (const AovInfo& aov : aov_table)
        if (aov.name == name)
            return aov;
    return std::nullopt;
}

}  // namespace equistream
