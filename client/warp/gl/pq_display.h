#pragma once
/// HDR pictures to a display's colours on the GPU: OpenColorIO's shader and the tables it reads. The context it was
/// made in is current in every call.
#include <client/gpu/program.h>

#include <equistream/hdr_display.h>

#include <array>
#include <vector>

namespace equistream::gl {

class PqDisplay {
public:
    /// Compiles its shader. Throws InputError in one line where that, or a table, is more than the driver takes.
    explicit PqDisplay(const HdrDisplay& display);

    double exposure_stops() const { return exposure_stops_; }
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

}  // namespace equistream::gl
