#pragma once
/// What a scene's surfaces look like unlit, as shaders read it (surface_colours.glsl): base colours, and the levels of
/// their textures, side by side in pages of one texture.
#include <gl/objects.h>

#include <equistream_scene/model.h>

#include <string>
#include <vector>

namespace equistream::gl {

class SurfaceColours {
public:
    /// Of a model with shading, whose textures it decodes: all that some instance shows. Throws WorkError where the
    /// driver has no storage for them.
    explicit SurfaceColours(const SceneModel& model);

    /// Storage blocks 3, 5, 6 and 7, the first instead of SceneGeometry's, and texture unit 4.
    void bind() const;
    /// What surface_colours.glsl must have defined.
    static std::vector<std::string> defines();

private:
    void upload_textures(const SceneModel& model);

    Buffer uvs_, surfaces_, textures_, levels_;
    Texture pages_;
};

}  // namespace equistream::gl
