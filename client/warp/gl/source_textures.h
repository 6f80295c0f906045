#pragma once
/// A source picture on the GPU, and HDR pictures to a display's colours.
#include "picture_buffers.h"

#include <equistream/colour.h>
#include <equistream/yuv.h>

#include <client/gpu/program.h>
#include <client/warp/view.h>

#include <array>
#include <memory>
#include <optional>
#include <vector>

namespace equistream::gl {

// HDR pictures to a display's colours on the GPU: OpenColorIO's shader and the tables it reads. The context it was
// made in is current in every call.

class PqDisplay {
public:
    /// Compiles its shader. Throws InputError in one line where that, or a table, is more than the driver takes.
    explicit PqDisplay(const HdrDisplay& display);

    /// Of pictures that are converted from now on.
    void set_exposure(double stops);

    /// Y', Cb and Cr (GL_R16UI) to a texture of GL_RGBA8 and of this size.
    void convert(const std::array<Texture, 3>& planes, const Texture& colour, Size size) const;

private:
    PqDisplay(const DisplayShader& shader, double exposure_stops);

    struct Table {
        Texture texture;
        GLuint sampler = 0;  ///< one of the two below
    };

    Program program_;
    std::string exposure_uniform_;
    double exposure_stops_ = 0;
    std::vector<Table> tables_;
    Sampler linear_, nearest_;
};

// A source picture on the GPU. The context it was made in is current in every call.

/// Who turns a decoder's planes of 8 bits into colours, the same ones. Where the driver itself runs on the CPU, loops
/// of C++ do it many times as fast as its shaders.
enum class PlaneReader { by_driver, cpu, gpu };

class SourceTextures {
public:
    explicit SourceTextures(PlaneReader reader = PlaneReader::by_driver);

    /// What directions of the source's samples are: for depth that a pass finds, where no picture is needed.
    void describe(const Camera& camera);
    /// Makes the depth of all samples unknown.
    void forget_depth();
    /// Uploads colour, and depth where the view has some (specular and virtual depth stay behind); the view's pixels
    /// are read before this returns. Storage is kept as long as sizes stay.
    void upload(const SourceView& source) { upload(source, {}); }
    /// The same of an HDR picture, whose colour is in `pq` where the view has none.
    void upload(const SourceView& source, const PqView& pq);
    /// Planes in these buffers are read there by the GPU, whoever reads others.
    void read_in_place(std::shared_ptr<PictureBuffers> buffers) { buffers_ = std::move(buffers); }
    /// How HDR pictures that are uploaded from now on come to the display. Until there is one, none may come.
    void show_pq_by(std::shared_ptr<const PqDisplay> display) { pq_display_ = std::move(display); }
    /// Trades what was uploaded, or made here; each keeps its ways to read and show what comes next.
    void swap_pictures(SourceTextures& other);
    /// An HDR picture once more, after its display's exposure changed; others stay.
    void show_again();

    Size size() const { return size_; }
    GLuint colour() const { return colour_.name(); }
    GLuint depth() const { return has_depth_ ? depth_.name() : 0; }  ///< 0: the view had none
    GLuint grid() const { return grid_.name(); }                     ///< the uniform block of source_grid.glsl
    /// The same texture for a pass that finds the depth here; where the view had none, NaN before that.
    GLuint depth_to_write();
    /// Colour for a pass that makes the picture here, of the camera that was described.
    GLuint colour_to_write();

private:
    void upload_rgb(const ImageView<const std::uint8_t>& rgb);
    void upload_yuv(const YuvView& yuv);
    bool convert_in_place(const YuvView& yuv);
    void run(const Program& yuv_to_rgb);
    void upload_pq(const PqView& pq);
    template <typename T>
    void upload_planes(const Yuv420View<T>& planes, GLenum storage, GLenum type);
    void make_depth();

    bool on_cpu_;
    std::optional<Program> from_textures_, from_buffer_;  ///< yuv_to_rgb.glsl's, once they were needed
    std::shared_ptr<PictureBuffers> buffers_;             ///< null: there are none
    ByteImage rgba_;                                      ///< memory for what the CPU makes
    Size size_;
    Texture colour_, depth_;
    bool has_depth_ = false;  ///< what depth_ holds is of this view
    std::array<Texture, 3> planes_;
    GLenum planes_storage_ = GL_NONE;  ///< of planes_
    bool is_pq_ = false;               ///< what colour_ holds came from there, and pq_display_ brought it
    std::shared_ptr<const PqDisplay> pq_display_;
    Buffer grid_;
};

}  // namespace equistream::gl
