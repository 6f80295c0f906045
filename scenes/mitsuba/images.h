#pragma once
/// Mitsuba's images wrap alike along both axes. One that is to wrap otherwise along v than along u is written as a
/// column of the tiles that some mesh's texture coordinates lie in, each as the wrap along v makes it.
#include "asset_folder.h"

#include <equistream/image.h>

#include <scenes/library/model.h>

#include <functional>
#include <map>
#include <optional>
#include <pugixml.hpp>

namespace equistream::mitsuba_xml {

struct Tiles {
    int first = 0, count = 1;  ///< of v: tile t is [t, t + 1)
};

/// The tiles along v that meshes with such a material cover, with one more at either end for filters; nothing if they
/// are too many for an image of that height, or a coordinate is not finite.
std::optional<Tiles> tiles_along_v(const SceneModel& model, int height,
                                   const std::function<bool(const Material&)>& uses);

/// For each row of that column the image's row.
std::vector<int> rows_of(const Tiles& tiles, int height, Wrap wrap_v);

// The scene's textures as image files. A texture that Mitsuba can take as it is keeps its bytes; one that a factor
// multiplies becomes a linear EXR, one that holds several quantities is split into channels.

/// As EXR, one channel or three: halves unless some value is too large. Throws WorkError naming the file.
void write_linear_image(AssetFolder& folder, const std::string& name, const FloatImage& image);

/// Asked for first, then written (many at once), then declared. Not thread-safe itself.
class Images {
public:
    Images(const SceneModel& model, AssetFolder& folder) : model_(model), folder_(folder) {}

    /// Each returns the id of a <texture> that declare() will put into the scene.
    std::string colour(std::uint32_t texture, const glm::vec3& factor = glm::vec3(1));
    /// The same cut away where the mask is.
    std::string emission(std::uint32_t texture, const glm::vec3& factor, std::uint32_t mask);
    std::string channel(std::uint32_t texture, int channel, float factor);
    std::string mask(std::uint32_t mask);

    /// Every image that was asked for. Throws InputError naming a texture that cannot be read.
    void write() const;
    void declare(pugi::xml_node scene) const;
    std::size_t count() const { return jobs_.size(); }
    /// Images that wrap along v as along u, though they should not: their meshes repeat them too often.
    std::size_t wrapped_alike() const { return wrapped_alike_; }

private:
    enum class Kind { as_it_is, coloured, single_channel, opacity };
    struct Job {
        Kind kind = Kind::as_it_is;
        std::string file;
        std::uint32_t texture = no_index, mask = no_index;
        glm::vec3 factor{1};
        int channel = 0;
        std::optional<Tiles> tiles;
    };

    std::string add(const std::string& id, Job job);
    void set_tiles(Job& job);
    Wrap wrap_u(const Job& job) const;
    Wrap wrap_v(const Job& job) const;
    void write(const Job& job) const;
    void write_channel(const Job& job, const FloatImage& image) const;

    const SceneModel& model_;
    AssetFolder& folder_;
    std::map<std::string, Job> jobs_;
    std::size_t wrapped_alike_ = 0;
};

}  // namespace equistream::mitsuba_xml
