#pragma once
/// A model's textures behind OpenImageIO's texture system: images embedded in the model are decoded from memory and
/// given MIP levels averaged in linear light (weighted by alpha where a mask cuts by it, so that what is cut away does
/// not bleed in).
///
/// A lookup takes the one texel that a random offset of half a texel, and of half a level, chooses: in the mean exactly
/// trilinear filtering, in linear light, for the price of one texel. Lookups as coarse as `coarse_side` texels are
/// answered from a copy of that level, fetched once from the texture system, without calling it.
///
/// A texture that is colour to one material and data to another is held twice, once in each coding.
#include <equistream/error.h>
#include <scenes/library/model.h>

#include <OpenImageIO/texture.h>

#include <array>
#include <memory>
#include <vector>

namespace equistream::embree_host {

struct MipChainSource;

/// Whether a texture's numbers are sRGB colours (decoded to linear) or plain numbers.
enum class TextureCoding { colour, data };

/// Where, how wide and as what a lookup is. `footprint` is its width in texture coordinates; `jitter` three numbers in
/// [0, 1) (1/2 each: the nearest texel of the nearest level).
struct TextureQuery {
    glm::vec2 uv;
    float footprint = 0;
    glm::vec3 jitter{0.5f};
    TextureCoding coding = TextureCoding::colour;
};

/// What decoded levels of textures may take: a quarter of the machine's memory, from 512 MB to 4096 MB. Where a picture
/// needs more at a time, whole levels are decoded over and over. Several renders may share a machine, and a job may be
/// granted less of it.
float cache_megabytes(double memory_bytes);

class Textures {
public:
    /// Decodes every texture as what the materials use it for (as colour if they do not); throws InputError naming the
    /// first that cannot be. `model` is borrowed.
    explicit Textures(const SceneModel& model);
    ~Textures();
    Textures(const Textures&) = delete;
    Textures& operator=(const Textures&) = delete;

    /// One per tracing thread; keeps OpenImageIO's per-thread state.
    class Reader {
    public:
        explicit Reader(const Textures& textures);
        ~Reader();
        Reader(const Reader&) = delete;
        Reader& operator=(const Reader&) = delete;

        /// Linear RGB (or, as data, the stored numbers) of the texture at `query`; some material uses it as that.
        glm::vec3 lookup(std::uint32_t texture, const TextureQuery& query);
        std::uint64_t calls() const { return calls_; }  ///< into the texture system

    private:
        const Textures& textures_;
        OIIO::TextureSystem::Perthread* perthread_;
        std::uint64_t calls_ = 0;
    };

    /// Linear mean of the whole texture as colour (for the power of textured emitters).
    glm::vec3 mean(std::uint32_t texture) const;

    static constexpr int coarse_side = 32;

private:
    struct Entry {
        OIIO::TextureSystem::TextureHandle* handle = nullptr;
        const std::array<float, 256>* decode = nullptr;
        OIIO::TextureOpt::Wrap wrap_u = OIIO::TextureOpt::WrapPeriodic, wrap_v = OIIO::TextureOpt::WrapPeriodic;
        bool nearest = false;
        int width = 0, height = 0, levels = 0;
        int coarse_level = 0, coarse_width = 0, coarse_height = 0;
        std::vector<std::array<std::uint8_t, 4>> coarse;
        glm::vec3 mean{0};
    };
    struct DestroySystem {
        void operator()(OIIO::TextureSystem* system) const { OIIO::TextureSystem::destroy(system, true); }
    };

    std::size_t place_of(std::uint32_t texture, TextureCoding coding) const {
        return coding == TextureCoding::colour ? texture : entries_.size() / 2 + texture;
    }
    /// `source` is complete.
    void add(const MipChainSource& source, Entry& entry);
    InputError failure(const Texture& texture) const;
    void fetch_coarse_level(const Texture& texture, Entry& entry);

    std::filesystem::path model_file_;
    std::vector<MipChainSource> sources_;  // outlive the system, which reads from them
    std::unique_ptr<OIIO::TextureSystem, DestroySystem> system_;
    std::vector<Entry> entries_;  // all as colour, then all as data; those without a use are empty
};

}  // namespace equistream::embree_host
