#include "images.h"

#include "xml.h"

#include <equistream/error.h>
#include <equistream/image.h>
#include <equistream/rec709.h>

#include <plugin/pictures/encoded_image.h>

#include <OpenImageIO/imageio.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

namespace equistream::mitsuba_xml {
namespace {

/// The extension of what Mitsuba is given as it is; empty for other images.
const char* extension_of(const Texture& texture) {
    const char* format = image_format(texture.encoded, texture.name);
    const std::string_view known = format ? format : "";
    return known == "png" ? ".png" : known == "jpeg" ? ".jpg" : "";
}

EncodedImage open(const SceneModel& model, const Texture& texture) {
    return {texture.encoded, texture.name, model.file.string() + ": texture \"" + texture.name + "\""};
}

/// RGB as stored, 0 to 1.
FloatImage decode(const SceneModel& model, const Texture& texture) {
    EncodedImage encoded = open(model, texture);
    const std::vector<std::uint8_t> bytes = encoded.read();
    const auto channels = static_cast<std::size_t>(encoded.channels());
    FloatImage image(encoded.width(), encoded.height(), 3);
    for (std::size_t i = 0; i < image.samples().size() / 3; ++i)
        for (std::size_t c = 0; c < 3; ++c)
            image.samples()[3 * i + c] = static_cast<float>(bytes[i * channels + (channels < 3 ? 0 : c)]) / 255;
    return image;
}

void write_image(AssetFolder& folder, const std::string& name, OIIO::ImageSpec spec, OIIO::TypeDesc type,
                 const void* pixels) {
    spec.attribute("DateTime", "1970:01:01 00:00:00");  // else now: the same scene gives the same bytes
    const std::filesystem::path file = folder.path_of(name);
    const auto output = OIIO::ImageOutput::create(file.string());
    if (!output)
        throw WorkError(file.string() + ": cannot be written: " + OIIO::geterror());
    if (!output->open(file.string(), spec) || !output->write_image(type, pixels) || !output->close())
        throw WorkError(file.string() + ": cannot be written: " + output->geterror());
    folder.count(std::filesystem::file_size(file));
}

/// The image's nearest texels on the mask's grid, black where the mask has cut.
FloatImage cut(const FloatImage& image, const AlphaMask& mask) {
    FloatImage result(mask.width, mask.height, 3);
    for (int y = 0; y < mask.height; ++y)
        for (int x = 0; x < mask.width; ++x) {
            const bool there = mask.opaque[static_cast<std::size_t>(y) * static_cast<std::size_t>(mask.width) +
                                           static_cast<std::size_t>(x)] != 0;
            const float* from = image.pixel(static_cast<int>(std::int64_t{x} * image.width() / mask.width),
                                            static_cast<int>(std::int64_t{y} * image.height() / mask.height));
            for (int c = 0; c < 3; ++c)
                result.pixel(x, y)[c] = there ? from[c] : 0.0f;
        }
    return result;
}

FloatImage column_of(const FloatImage& image, const std::vector<int>& rows) {
    FloatImage column(image.width(), static_cast<int>(rows.size()), image.channels());
    for (int y = 0; y < column.height(); ++y)
        std::copy_n(image.pixel(0, rows[static_cast<std::size_t>(y)]), image.width() * image.channels(),
                    column.pixel(0, y));
    return column;
}

/// Texture coordinates of the column from those of the mesh; Mitsuba leaves z out of the matrix.
glm::dmat4 column_from_v(const Tiles& tiles) {
    glm::dmat4 m(1);
    m[1][1] = 1.0 / tiles.count;
    m[3][1] = static_cast<double>(-tiles.first) / tiles.count;
    return m;
}

FloatImage white() {
    FloatImage image(1, 1, 3);
    std::fill_n(image.pixel(0, 0), 3, 1.0f);
    return image;
}

const char* wrap_name(Wrap wrap) {
    return wrap == Wrap::clamp ? "clamp" : wrap == Wrap::mirror ? "mirror" : "repeat";
}

std::string factor_text(const glm::vec3& factor) {
    const auto bits = [](float v) {
        std::uint32_t b;
        std::memcpy(&b, &v, sizeof b);
        return std::to_string(b);
    };
    return bits(factor.x) + "-" + bits(factor.y) + "-" + bits(factor.z);
}

}  // namespace

void write_linear_image(AssetFolder& folder, const std::string& name, const FloatImage& image) {
    constexpr float max_half = 65504;
    const auto samples = image.samples();
    const bool fits = std::all_of(samples.begin(), samples.end(), [](float v) { return v <= max_half; });
    write_image(folder, name,
                OIIO::ImageSpec(image.width(), image.height(), image.channels(),
                                fits ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT),
                OIIO::TypeDesc::FLOAT, samples.data());
}

std::string Images::add(const std::string& id, Job job) {
    const auto [entry, added] = jobs_.try_emplace(id, std::move(job));
    if (added && wrap_u(entry->second) != wrap_v(entry->second))
        set_tiles(entry->second);
    return id;
}

Wrap Images::wrap_u(const Job& job) const {
    return job.mask != no_index ? model_.alpha_masks[job.mask].wrap_u : model_.textures[job.texture].wrap_u;
}

Wrap Images::wrap_v(const Job& job) const {
    return job.mask != no_index ? model_.alpha_masks[job.mask].wrap_v : model_.textures[job.texture].wrap_v;
}

void Images::set_tiles(Job& job) {
    const int height = job.mask != no_index ? model_.alpha_masks[job.mask].height
                                            : open(model_, model_.textures[job.texture]).height();
    job.tiles = tiles_along_v(model_, height, [&job](const Material& m) {
        return job.mask != no_index ? m.alpha_mask == job.mask
                                    : m.base_colour_texture == job.texture || m.emission_texture == job.texture ||
                                          m.metallic_roughness_texture == job.texture;
    });
    wrapped_alike_ += !job.tiles;
    if (job.kind == Kind::as_it_is && job.tiles) {
        job.kind = Kind::coloured;
        job.file = std::filesystem::path(job.file).replace_extension(".exr").string();
    }
}

std::string Images::colour(std::uint32_t texture, const glm::vec3& factor) {
    const std::string name = "texture-" + std::to_string(texture);
    const std::string extension = extension_of(model_.textures[texture]);
    if (factor == glm::vec3(1) && !extension.empty())
        return add(name, {Kind::as_it_is, name + extension, texture, no_index, factor, 0, {}});
    const std::string tinted = factor == glm::vec3(1) ? name : name + "-times-" + factor_text(factor);
    return add(tinted, {Kind::coloured, tinted + ".exr", texture, no_index, factor, 0, {}});
}

std::string Images::emission(std::uint32_t texture, const glm::vec3& factor, std::uint32_t mask) {
    std::string name = texture == no_index ? "emission" : "emission-" + std::to_string(texture);
    name += "-times-" + factor_text(factor);
    if (mask != no_index)
        name += "-masked-" + std::to_string(mask);
    return add(name, {Kind::coloured, name + ".exr", texture, mask, factor, 0, {}});
}

std::string Images::channel(std::uint32_t texture, int channel, float factor) {
    static constexpr const char* names[] = {"-red", "-green", "-blue"};
    const std::string name = "texture-" + std::to_string(texture) + names[channel] +
                             (factor == 1 ? std::string() : "-times-" + factor_text(glm::vec3(factor)));
    return add(name, {Kind::single_channel,
                      name + (factor == 1 ? ".png" : ".exr"),
                      texture,
                      no_index,
                      glm::vec3(factor),
                      channel,
                      {}});
}

std::string Images::mask(std::uint32_t mask) {
    const std::string name = "mask-" + std::to_string(mask);
    return add(name, {Kind::opacity, name + ".png", no_index, mask, glm::vec3(1), 0, {}});
}

void Images::write() const {
    std::vector<const Job*> jobs;
    for (const auto& [id, job] : jobs_)
        jobs.push_back(&job);
    tbb::parallel_for(std::size_t{0}, jobs.size(), [&](std::size_t i) { write(*jobs[i]); });
}

void Images::write(const Job& job) const {
    if (job.kind == Kind::as_it_is) {
        open(model_, model_.textures[job.texture]);  // finds what is cut short before Mitsuba does
        return folder_.write_file(job.file, model_.textures[job.texture].encoded);
    }
    if (job.kind == Kind::opacity) {
        const AlphaMask& mask = model_.alpha_masks[job.mask];
        const std::vector<int> rows = rows_of(job.tiles.value_or(Tiles{}), mask.height, mask.wrap_v);
        std::vector<std::uint8_t> opaque;
        for (const int row : rows)
            opaque.insert(opaque.end(), mask.opaque.begin() + std::ptrdiff_t{row} * mask.width,
                          mask.opaque.begin() + std::ptrdiff_t{row + 1} * mask.width);
        return write_image(folder_, job.file,
                           OIIO::ImageSpec(mask.width, static_cast<int>(rows.size()), 1, OIIO::TypeDesc::UINT8),
                           OIIO::TypeDesc::UINT8, opaque.data());
    }
    FloatImage image = job.texture == no_index ? white() : decode(model_, model_.textures[job.texture]);
    if (job.kind == Kind::single_channel)
        return write_channel(job,
                             job.tiles ? column_of(image, rows_of(*job.tiles, image.height(), wrap_v(job))) : image);
    for (std::size_t i = 0; i < image.samples().size(); ++i)
        image.samples()[i] = srgb_to_linear(image.samples()[i]) * job.factor[static_cast<int>(i % 3)];
    if (job.mask != no_index)
        image = cut(image, model_.alpha_masks[job.mask]);
    if (job.tiles)
        image = column_of(image, rows_of(*job.tiles, image.height(), wrap_v(job)));
    write_linear_image(folder_, job.file, image);
}

/// As it is in 8 bits; halves where a factor changes it.
void Images::write_channel(const Job& job, const FloatImage& image) const {
    FloatImage values(image.width(), image.height(), 1);
    for (std::size_t i = 0; i < values.samples().size(); ++i)
        values.samples()[i] = job.factor.x * image.samples()[3 * i + static_cast<std::size_t>(job.channel)];
    if (job.factor.x != 1)
        return write_linear_image(folder_, job.file, values);
    write_image(folder_, job.file, OIIO::ImageSpec(image.width(), image.height(), 1, OIIO::TypeDesc::UINT8),
                OIIO::TypeDesc::FLOAT, values.samples().data());
}

void Images::declare(pugi::xml_node scene) const {
    for (const auto& [id, job] : jobs_) {
        pugi::xml_node node = add_plugin(scene, "texture", "bitmap", id);
        add_text(node, "filename", folder_.reference_to(job.file));
        add_text(node, "wrap_mode", wrap_name(wrap_u(job)));
        if (job.tiles)
            add_transform(node, "to_uv", column_from_v(*job.tiles));
        if (job.mask != no_index || model_.textures[job.texture].nearest)
            add_text(node, "filter_type", "nearest");
        // Radiance above 1 is no reflectance, for which Mitsuba would take it.
        const bool radiance = std::max({job.factor.x, job.factor.y, job.factor.z}) > 1;
        if (job.kind == Kind::opacity || job.kind == Kind::single_channel || radiance)
            add_boolean(node, "raw", true);
    }
}

std::optional<Tiles> tiles_along_v(const SceneModel& model, int height,
                                   const std::function<bool(const Material&)>& uses) {
    float low = 0, high = 1;
    for (const Mesh& mesh : model.meshes) {
        if (!uses(model.materials[std::min<std::size_t>(mesh.material, model.materials.size() - 1)]))
            continue;
        for (const glm::vec2& uv : mesh.uvs) {
            if (!std::isfinite(uv.y))
                return std::nullopt;
            low = std::min(low, uv.y);
            high = std::max(high, uv.y);
        }
    }
    const double count = std::ceil(high) - std::floor(low) + 2.0;
    if (count * height > max_image_side)
        return std::nullopt;
    return Tiles{static_cast<int>(std::floor(low)) - 1, static_cast<int>(count)};
}

std::vector<int> rows_of(const Tiles& tiles, int height, Wrap wrap_v) {
    std::vector<int> rows;
    for (int tile = tiles.first; tile < tiles.first + tiles.count; ++tile)
        for (int y = 0; y < height; ++y) {
            if (wrap_v == Wrap::clamp)
                rows.push_back(tile < 0 ? 0 : tile > 0 ? height - 1 : y);
            else
                rows.push_back(wrap_v == Wrap::mirror && tile % 2 != 0 ? height - 1 - y : y);
        }
    return rows;
}

}  // namespace equistream::mitsuba_xml
