#include "denoiser.h"
#include "oidn.h"

#include <equistream/camera_limits.h>
#include <equistream/error.h>

#include <plugin/export/parallel.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace equistream {
namespace {

/// How far around a pixel the network looks: what lies farther away changes nothing.
constexpr int margin = 96;
/// Beyond a seam. What is left out changes pixels beside it by up to 0.2 of 255, root mean square
/// (docs/results/denoise.md).
constexpr int seam_margin = 64;
/// Over a pole a picture is stretched so much that little of it is near.
constexpr int pole_margin = 32;
/// Pixels of a block's own along a side, at most.
constexpr int widest = 2560, highest = 1536;
/// What the library may take for one block.
constexpr int scratch_mib = 1536;
constexpr float max_radiance = 65504;  // of a half float

constexpr const char* image_names[] = {"color", "albedo", "normal"};

/// Along one axis: blocks of one size that cover `length`, each with what lies around it.
struct Cut {
    int count, interior, size;
    int low, high;  ///< places that exist: 0 and length, or beyond where the picture goes on

    Cut(int length, int most, int around) : low(-around), high(length + around) {
        count = (length + most - 1) / most;
        interior = (length + count - 1) / count;
        size = std::min(interior + 2 * margin, high - low);
    }
    /// First place of the i-th block's own, and of the block.
    int own(int i, int length) const { return std::min(i * interior, length - interior); }
    int begin(int i, int length) const { return std::clamp(own(i, length) - margin, low, high - size); }
};

}  // namespace

/// Which pixels a frame's blocks hold.
class Denoiser::Blocks {
public:
    explicit Blocks(const FrameInfo& info)
        : width(picture_width(info)), height(picture_height(info)), closes(columns_close(info.camera) && !info.patches),
          meets_poles(closes && rows_meet_poles(std::get<EquirectCamera>(info.camera))),
          across(width, widest, closes ? seam_margin : 0),
          down(height, highest, meets_poles ? std::min(pole_margin, height) : 0) {}

    int count() const { return across.count * down.count; }
    int left(int block) const { return across.begin(block % across.count, width); }
    int top(int block) const { return down.begin(block / across.count, height); }
    int own_left(int block) const { return across.own(block % across.count, width); }
    int own_top(int block) const { return down.own(block / across.count, height); }

    /// The picture's pixel (column, row) where a block's row begins; the place may lie beyond the picture's edges.
    std::pair<int, int> row_begin(int x, int y) const {
        if (y < 0 || y >= height) {  // over the pole and down the other side
            y = y < 0 ? -1 - y : 2 * height - 1 - y;
            x += width / 2;
        }
        x %= width;
        return {x < 0 ? x + width : x, y};
    }

    int width, height;
    bool closes, meets_poles;
    Cut across, down;

private:
    static bool rows_meet_poles(const EquirectCamera& camera) {
        constexpr double close = 1e-9;
        return camera.range.latitude_min <= -pi / 2 + close && camera.range.latitude_max >= pi / 2 - close;
    }
};

Denoiser::Denoiser(DenoiseQuality quality, unsigned threads)
    : device_(oidn::shared_device(threads)), quality_(quality),
      description_(device_->name() + ", " + denoise_quality_names[static_cast<std::size_t>(quality)]) {}

Denoiser::~Denoiser() {
    release();
}

void Denoiser::release() {
    const oidn::Library& library = device_->functions();
    if (filter_ != nullptr)
        library.release_filter(std::exchange(filter_, nullptr));
    for (void*& buffer : buffers_)
        if (buffer != nullptr)
            library.release_buffer(std::exchange(buffer, nullptr));
    job_ = {};
}

/// A filter for blocks of this size, colour and guides.
void Denoiser::prepare(const Job& job) {
    if (filter_ != nullptr && job == job_)
        return;
    release();
    const oidn::Library& library = device_->functions();
    const auto columns = static_cast<std::size_t>(job.width), rows = static_cast<std::size_t>(job.height);
    staging_.resize(columns * rows * 3);
    filter_ = library.new_filter(device_->handle(), "RT");
    for (std::size_t i = 0; i < job.images; ++i) {
        buffers_[i] = library.new_buffer(device_->handle(), staging_.size() * sizeof(float));
        device_->check("denoise: memory");
        library.set_filter_image(filter_, image_names[i], buffers_[i], oidn::float3, columns, rows, 0, 0, 0);
    }
    library.set_filter_image(filter_, "output", buffers_[0], oidn::float3, columns, rows, 0, 0, 0);
    constexpr int qualities[] = {0, oidn::fast, oidn::balanced, oidn::high};
    library.set_filter_int(filter_, "quality", qualities[static_cast<int>(quality_)]);
    library.set_filter_bool(filter_, "hdr", true);
    library.set_filter_bool(filter_, "cleanAux", job.filtered_guides);
    library.set_filter_int(filter_, "maxMemoryMB", scratch_mib);
    // Not as the library finds it itself: neighbouring frames, and the blocks of one, are to be treated alike.
    library.set_filter_float(filter_, "inputScale", job.exposure);
    library.commit_filter(filter_);
    device_->check("denoise");
    job_ = job;  // last: a filter that is not whole is made anew
}

void Denoiser::fill(const Blocks& blocks, int block, const FloatImage& image, std::size_t slot, float least,
                    float most) {
    for_each_row(job_.height, [&](int y) {
        float* to = staging_.data() + std::size_t(3) * std::size_t(job_.width) * std::size_t(y);
        auto [column, row] = blocks.row_begin(blocks.left(block), blocks.top(block) + y);
        for (int x = 0; x < job_.width; ++x, to += 3) {
            const float* from = image.pixel(column, row);
            for (int c = 0; c < 3; ++c)
                to[c] = std::isfinite(from[c]) ? std::clamp(from[c], least, most) : 0;
            column = column + 1 == blocks.width ? 0 : column + 1;
        }
    });
    device_->functions().write_buffer(buffers_[slot], 0, staging_.size() * sizeof(float), staging_.data());
}

void Denoiser::denoise(Frame& frame) {
    const auto plane = [&](const char* name) -> const FloatImage* {
        const auto found = frame.planes.find(name);
        return found == frame.planes.end() ? nullptr : &found->second;
    };
    const bool filtered = plane("guide_albedo") != nullptr;
    const FloatImage* const albedo = plane(filtered ? "guide_albedo" : "albedo");
    // The library takes no normals without albedo.
    const FloatImage* const normal = albedo != nullptr ? plane(filtered ? "guide_normal" : "normal") : nullptr;
    const Blocks blocks(frame.info);
    prepare({blocks.across.size, blocks.down.size, std::size_t{1} + (albedo != nullptr) + (normal != nullptr),
             static_cast<float>(frame.info.exposure), filtered});
    const oidn::Library& library = device_->functions();
    FloatImage& colour = frame.planes.at("colour");
    if (blocks.count() > 1)
        noisy_ = colour;
    for (int block = 0; block < blocks.count(); ++block) {
        fill(blocks, block, blocks.count() > 1 ? noisy_ : colour, 0, 0, max_radiance);
        if (albedo != nullptr)
            fill(blocks, block, *albedo, 1, 0, 1);
        if (normal != nullptr)
            fill(blocks, block, *normal, 2, -1, 1);
        library.execute_filter(filter_);
        device_->check("denoise");
        library.read_buffer(buffers_[0], 0, staging_.size() * sizeof(float), staging_.data());
        const int left = blocks.own_left(block), top = blocks.own_top(block);
        for_each_row(blocks.down.interior, [&](int row) {
            const int y = top + row;
            const auto first = static_cast<std::size_t>(y - blocks.top(block)) * static_cast<std::size_t>(job_.width) +
                               static_cast<std::size_t>(left - blocks.left(block));
            const float* from = staging_.data() + 3 * first;
            for (int x = left; x < left + blocks.across.interior; ++x, from += 3)
                for (int c = 0; c < 3; ++c)
                    colour.pixel(x, y)[c] = std::isfinite(from[c]) ? from[c] : 0;
        });
    }
    device_->check("denoise");
}

}  // namespace equistream
