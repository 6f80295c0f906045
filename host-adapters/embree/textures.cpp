#include "textures.h"

#include "mip_chain.h"

#include <OpenImageIO/imagecache.h>

#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>

namespace equistream::embree_host {
namespace {

OIIO::TextureOpt::Wrap oiio_wrap(Wrap wrap) {
    switch (wrap) {
    case Wrap::clamp:
        return OIIO::TextureOpt::WrapClamp;
    case Wrap::mirror:
        return OIIO::TextureOpt::WrapMirror;
    case Wrap::repeat:
        break;
    }
    return OIIO::TextureOpt::WrapPeriodic;
}

int wrapped(int i, int n, OIIO::TextureOpt::Wrap wrap) {
    if (wrap == OIIO::TextureOpt::WrapClamp)
        return std::clamp(i, 0, n - 1);
    if (wrap == OIIO::TextureOpt::WrapMirror) {
        const int m = ((i % (2 * n)) + 2 * n) % (2 * n);
        return m < n ? m : 2 * n - 1 - m;
    }
    const int m = i % n;
    return m < 0 ? m + n : m;
}

int floor_to_int(float x) {
    const int i = static_cast<int>(x);
    return i - (x < static_cast<float>(i) ? 1 : 0);
}

/// floor(log2(x)) + t for x = 2^k (1 + t): within 0.09 of log2, and a shift and a subtraction.
float rough_log2(float x) {
    const auto bits = std::bit_cast<std::int32_t>(x);
    return static_cast<float>(bits - 0x3f800000) * 0x1p-23f;
}

/// Of the machine; 0 where it does not say.
double machine_memory_bytes() {
    const long pages = sysconf(_SC_PHYS_PAGES), page_bytes = sysconf(_SC_PAGESIZE);
    return pages > 0 && page_bytes > 0 ? static_cast<double>(pages) * static_cast<double>(page_bytes) : 0;
}

/// Coordinates beyond this say nothing about a texel any more, and would overflow an int.
float bounded(float coordinate) {
    return coordinate > -1e5f && coordinate < 1e5f ? coordinate : 0.0f;
}

struct Uses {
    bool as_colour = false, as_data = false, is_cut = false;
};

std::vector<Uses> uses_of_textures(const SceneModel& model) {
    std::vector<Uses> uses(model.textures.size());
    for (const Material& material : model.materials) {
        for (const std::uint32_t colour : {material.base_colour_texture, material.emission_texture})
            if (colour != no_index)
                uses[colour].as_colour = true;
        if (material.metallic_roughness_texture != no_index)
            uses[material.metallic_roughness_texture].as_data = true;
        if (material.base_colour_texture != no_index && material.alpha_mask != no_index)
            uses[material.base_colour_texture].is_cut = true;
    }
    return uses;
}

constexpr double cache_share_of_memory = 0.25, min_cache_megabytes = 512, max_cache_megabytes = 4096;

}  // namespace

float cache_megabytes(double memory_bytes) {
    const double share = cache_share_of_memory * memory_bytes * 0x1p-20;
    return static_cast<float>(std::clamp(share, min_cache_megabytes, max_cache_megabytes));
}

Textures::Textures(const SceneModel& model)
    : model_file_(model.file), sources_(2 * model.textures.size()), system_(OIIO::TextureSystem::create(false)),
      entries_(2 * model.textures.size()) {
    system_->attribute("max_memory_MB", cache_megabytes(machine_memory_bytes()));
    system_->attribute("max_open_files", 4096);
    system_->attribute("autotile", 0);
    system_->attribute("forcefloat", 0);
    const std::vector<Uses> uses = uses_of_textures(model);
    tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(uses.size()), [&](std::uint32_t i) {
        const auto add_as = [&](TextureCoding coding) {
            const std::size_t place = place_of(i, coding);
            sources_[place] = {&model.textures[i], coding, coding == TextureCoding::colour && uses[i].is_cut};
            add(sources_[place], entries_[place]);
        };
        if (uses[i].as_data)
            add_as(TextureCoding::data);
        if (uses[i].as_colour || !uses[i].as_data)
            add_as(TextureCoding::colour);
    });
}

Textures::~Textures() = default;

void Textures::add(const MipChainSource& source, Entry& entry) {
    const Texture& texture = *source.texture;
    const MipChainSource* pointer = &source;
    OIIO::ImageSpec config;
    config.attribute(mip_source_attribute, OIIO::TypeDesc::PTR, static_cast<const void*>(&pointer));
    const OIIO::ustring name("texture-" + std::to_string(&source - sources_.data()));
    const auto fail = [&] { return failure(texture); };
    if (!system_->imagecache()->add_file(name, create_mip_chain_input, &config))
        throw fail();
    entry.handle = system_->get_texture_handle(name);
    if (!entry.handle || !system_->good(entry.handle))
        throw fail();
    const OIIO::ImageSpec* spec = system_->imagespec(entry.handle, nullptr);
    if (!spec)
        throw fail();
    entry.width = spec->width;
    entry.height = spec->height;
    entry.levels = mip_level_count(spec->width, spec->height);
    entry.decode = &decode_table(source.coding);
    entry.wrap_u = oiio_wrap(texture.wrap_u);
    entry.wrap_v = oiio_wrap(texture.wrap_v);
    entry.nearest = texture.nearest;
    fetch_coarse_level(texture, entry);
}

InputError Textures::failure(const Texture& texture) const {
    std::string text = system_->imagecache()->geterror();
    if (text.empty())
        text = system_->geterror();
    return InputError(model_file_.string() + ": texture \"" + texture.name + "\": " + text);
}

void Textures::fetch_coarse_level(const Texture& texture, Entry& entry) {
    const int excess = std::bit_width(static_cast<unsigned>((std::max(entry.width, entry.height) - 1) / coarse_side));
    entry.coarse_level = std::min(excess, entry.levels - 1);
    entry.coarse_width = std::max(1, entry.width >> entry.coarse_level);
    entry.coarse_height = std::max(1, entry.height >> entry.coarse_level);
    entry.coarse.resize(static_cast<std::size_t>(entry.coarse_width) * static_cast<std::size_t>(entry.coarse_height));
    std::vector<std::uint8_t> rgb(entry.coarse.size() * 3);
    OIIO::TextureOpt options;
    if (!system_->get_texels(entry.handle, nullptr, options, entry.coarse_level, 0, entry.coarse_width, 0,
                             entry.coarse_height, 0, 1, 0, 3, OIIO::TypeDesc::UINT8, rgb.data()))
        throw failure(texture);
    glm::dvec3 sum{0};
    for (std::size_t i = 0; i < entry.coarse.size(); ++i) {
        entry.coarse[i] = {rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2], 255};
        for (int c = 0; c < 3; ++c)
            sum[c] += (*entry.decode)[rgb[3 * i + static_cast<std::size_t>(c)]];
    }
    entry.mean = glm::vec3(sum / static_cast<double>(entry.coarse.size()));
}

glm::vec3 Textures::mean(std::uint32_t texture) const {
    return entries_[place_of(texture, TextureCoding::colour)].mean;
}

Textures::Reader::Reader(const Textures& textures)
    : textures_(textures), perthread_(textures.system_->create_thread_info()) {}

Textures::Reader::~Reader() {
    textures_.system_->destroy_thread_info(perthread_);
}

glm::vec3 Textures::Reader::lookup(std::uint32_t texture, const TextureQuery& query) {
    const Entry& e = textures_.entries_[textures_.place_of(texture, query.coding)];
    assert(e.handle != nullptr);
    const std::array<float, 256>& decode = *e.decode;
    const float footprint_texels = query.footprint * static_cast<float>(std::max(e.width, e.height));
    const int level = std::clamp(floor_to_int(rough_log2(footprint_texels) + query.jitter.z), 0, e.levels - 1);
    glm::vec2 uv{bounded(query.uv.x), bounded(query.uv.y)};
    const glm::vec2 offset = e.nearest ? glm::vec2(0) : glm::vec2(query.jitter) - 0.5f;

    if (level >= e.coarse_level) {
        const float u = uv.x * static_cast<float>(e.coarse_width) + offset.x;
        const float v = uv.y * static_cast<float>(e.coarse_height) + offset.y;
        const int x = wrapped(floor_to_int(u), e.coarse_width, e.wrap_u);
        const int y = wrapped(floor_to_int(v), e.coarse_height, e.wrap_v);
        const auto& texel = e.coarse[static_cast<std::size_t>(y) * static_cast<std::size_t>(e.coarse_width) +
                                     static_cast<std::size_t>(x)];
        return {decode[texel[0]], decode[texel[1]], decode[texel[2]]};
    }

    const auto width = static_cast<float>(std::max(1, e.width >> level));
    const auto height = static_cast<float>(std::max(1, e.height >> level));
    uv += offset / glm::vec2(width, height);
    OIIO::TextureOpt options;
    options.swrap = e.wrap_u;
    options.twrap = e.wrap_v;
    options.interpmode = OIIO::TextureOpt::InterpClosest;
    options.mipmode = OIIO::TextureOpt::MipModeOneLevel;
    // The texture system takes the finest level on which this is at most one texel of the shorter side: the one chosen
    // above, or, once that side is one texel long, the first on which it is.
    const float derivative = 0.75f / std::min(width, height);
    float rgb[3];
    ++calls_;
    if (!textures_.system_->texture(e.handle, perthread_, options, uv.x, uv.y, derivative, 0, 0, derivative, 3, rgb))
        return e.mean;
    const auto code = [](float v) { return static_cast<std::size_t>(v * 255 + 0.5f) & 255u; };
    return {decode[code(rgb[0])], decode[code(rgb[1])], decode[code(rgb[2])]};
}

}  // namespace equistream::embree_host
