#include "mip_chain.h"

#include <plugin/pictures/encoded_image.h>

#include <equistream/error.h>
#include <equistream/rec709.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>

namespace equistream::embree_host {
namespace {

/// Linear RGB premultiplied by alpha, and alpha: one channel of four numbers.
using LinearImage = Image<glm::vec4>;

/// 8-bit RGBA; alpha is 255 where the file has none.
ByteImage decode_rgba(EncodedImage& image) {
    const std::vector<std::uint8_t> raw = image.read();
    const auto channels = static_cast<std::size_t>(image.channels());
    ByteImage decoded(image.width(), image.height(), 4, 255);
    const auto rgba = decoded.samples();
    for (std::size_t i = 0; i < rgba.size() / 4; ++i) {
        const std::uint8_t* in = &raw[i * channels];
        const bool grey = channels < 3;
        rgba[4 * i] = in[0];
        rgba[4 * i + 1] = in[grey ? 0 : 1];
        rgba[4 * i + 2] = in[grey ? 0 : 2];
        if (image.alpha_channel() >= 0)
            rgba[4 * i + 3] = in[image.alpha_channel()];
    }
    return decoded;
}

LinearImage linearise(const ByteImage& rgba, TextureCoding coding, bool is_cut) {
    const auto& table = decode_table(coding);
    LinearImage image(rgba.width(), rgba.height(), 1);
    for (std::size_t i = 0; i < image.samples().size(); ++i) {
        const std::uint8_t* in = &rgba.samples()[4 * i];
        // Texels that are cut away keep a trace of weight, so that a wholly empty region keeps its colour.
        const float a = is_cut ? std::max(static_cast<float>(in[3]) / 255, 1e-3f) : 1;
        image.samples()[i] = {table[in[0]] * a, table[in[1]] * a, table[in[2]] * a, a};
    }
    return image;
}

/// Box filter to half the size; an odd side's last row or column joins its neighbours.
LinearImage halve(const LinearImage& image) {
    LinearImage half(std::max(1, image.width() / 2), std::max(1, image.height() / 2), 1);
    for (int y = 0; y < half.height(); ++y)
        for (int x = 0; x < half.width(); ++x) {
            const int x0 = x * image.width() / half.width(), x1 = (x + 1) * image.width() / half.width();
            const int y0 = y * image.height() / half.height(), y1 = (y + 1) * image.height() / half.height();
            glm::vec4 sum{0};
            for (int sy = y0; sy < y1; ++sy)
                for (int sx = x0; sx < x1; ++sx)
                    sum += *image.pixel(sx, sy);
            *half.pixel(x, y) = sum / static_cast<float>((x1 - x0) * (y1 - y0));
        }
    return half;
}

ByteImage encode(const LinearImage& image, TextureCoding coding) {
    ByteImage rgb(image.width(), image.height(), 3);
    for (std::size_t i = 0; i < image.samples().size(); ++i) {
        const glm::vec4& t = image.samples()[i];
        for (int c = 0; c < 3; ++c) {
            const float linear = t[c] / t.w;
            const float code = coding == TextureCoding::colour ? linear_to_srgb(linear) : linear;
            rgb.samples()[3 * i + static_cast<std::size_t>(c)] =
                static_cast<std::uint8_t>(std::clamp(code * 255 + 0.5f, 0.0f, 255.0f));
        }
    }
    return rgb;
}

/// Serves a MipChainSource. The texture cache opens it again for every level it wants and keeps what it has read, so
/// opening costs a look at the header, and a read makes that level and no other.
class MipChainInput final : public OIIO::ImageInput {
public:
    const char* format_name() const override { return "equistream-mip-chain"; }
    bool open(const std::string&, OIIO::ImageSpec&) override { return false; }

    bool open(const std::string&, OIIO::ImageSpec& spec, const OIIO::ImageSpec& config) override {
        const auto* attribute = config.find_attribute(mip_source_attribute);
        if (!attribute)
            return false;
        std::memcpy(&source_, attribute->data(), sizeof(source_));  // NOLINT(bugprone-sizeof-expression): the pointer
        const bool opened = reporting([&] {
            const EncodedImage image(source_->texture->encoded, source_->texture->name);
            width_ = image.width();
            height_ = image.height();
        });
        if (!opened || !seek_subimage(0, 0))
            return false;
        spec = m_spec;
        return true;
    }

    bool close() override {
        level_ = {};
        return true;
    }

    int current_miplevel() const override { return miplevel_; }

    bool seek_subimage(int subimage, int miplevel) override {
        if (subimage != 0 || miplevel < 0 || miplevel >= mip_level_count(width_, height_))
            return false;
        miplevel_ = miplevel;
        m_spec = OIIO::ImageSpec(std::max(1, width_ >> miplevel), std::max(1, height_ >> miplevel), 3,
                                 OIIO::TypeDesc::UINT8);
        return true;
    }

    bool read_native_scanline(int subimage, int miplevel, int y, int z, void* data) override {
        return read_native_scanlines(subimage, miplevel, y, y + 1, z, data);
    }

    bool read_native_scanlines(int subimage, int miplevel, int y_begin, int y_end, int, void* data) override {
        const OIIO::ImageInput::lock_guard lock(*this);
        if (!seek_subimage(subimage, miplevel))
            return false;
        if ((level_.empty() || made_ != miplevel) && !reporting([&] { level_ = make_mip_level(*source_, miplevel); }))
            return false;
        made_ = miplevel;
        std::memcpy(data, level_.pixel(0, y_begin), static_cast<std::size_t>(y_end - y_begin) * 3 * level_.width());
        if (y_end == level_.height())
            level_ = {};
        return true;
    }

private:
    template <typename Work>
    bool reporting(const Work& work) {
        try {
            work();
            return true;
        } catch (const InputError& e) {
            errorfmt("{}", e.what());
            return false;
        }
    }

    const MipChainSource* source_ = nullptr;
    int width_ = 0, height_ = 0;
    int miplevel_ = 0;
    ByteImage level_;  ///< the one that was made last, until its last row is handed over
    int made_ = 0;
};

}  // namespace

const std::array<float, 256>& decode_table(TextureCoding coding) {
    static const auto make = [](TextureCoding c) {
        std::array<float, 256> table{};
        for (std::size_t i = 0; i < 256; ++i) {
            const float v = static_cast<float>(i) / 255;
            table[i] = c == TextureCoding::colour ? srgb_to_linear(v) : v;
        }
        return table;
    };
    static const std::array<float, 256> colour = make(TextureCoding::colour), data = make(TextureCoding::data);
    return coding == TextureCoding::colour ? colour : data;
}

int mip_level_count(int width, int height) {
    return std::bit_width(static_cast<unsigned>(std::max(width, height)));
}

ByteImage make_mip_level(const MipChainSource& source, int level) {
    EncodedImage encoded(source.texture->encoded, source.texture->name);
    assert(level >= 0 && level < mip_level_count(encoded.width(), encoded.height()));
    const ByteImage rgba = decode_rgba(encoded);
    if (level == 0) {
        ByteImage full(rgba.width(), rgba.height(), 3);
        for (std::size_t i = 0; i < rgba.samples().size() / 4; ++i)
            std::copy_n(&rgba.samples()[4 * i], 3, &full.samples()[3 * i]);
        return full;
    }
    LinearImage image = linearise(rgba, source.coding, source.is_cut);
    for (int i = 0; i < level; ++i)
        image = halve(image);
    return encode(image, source.coding);
}

OIIO::ImageInput* create_mip_chain_input() {
    return new MipChainInput;
}

}  // namespace equistream::embree_host
