#include "view_writer.h"

#include <equistream/colour.h>
#include <equistream/error.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>
#include <equistream/stream.h>

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

namespace equistream::play {

namespace fs = std::filesystem;

namespace {

std::int64_t size_of(const fs::path& file) {
    std::error_code error;
    const auto size = fs::file_size(file, error);
    return error ? 0 : std::int64_t(size);
}

class PngViews : public ViewWriter {
public:
    explicit PngViews(fs::path folder) : folder_(std::move(folder)) { require_writable_folder(folder_); }
    void write(const FinishedView& view) override {
        const fs::path file = folder_ / frame_file_name(view.info.index, "png");
        write_picture(file, view.picture.rgb().view());
        bytes_ += size_of(file);
    }
    void finish() override {}
    std::int64_t bytes() const override { return bytes_; }

private:
    fs::path folder_;
    std::int64_t bytes_ = 0;
};

/// Scene-referred again: the display transform and the exposure are undone.
class ExrViews : public ViewWriter {
public:
    explicit ExrViews(fs::path folder) : folder_(std::move(folder)) { require_writable_folder(folder_); }
    void write(const FinishedView& view) override {
        const FloatImage linear = display_.to_linear(widen_8bit(view.picture.rgb().view()).view(), view.info.exposure);
        Frame frame;
        frame.info = view.info;
        frame.planes["colour"] = with_alpha(linear, view.picture.origin);
        if (view.depth_m.data != nullptr)
            frame.planes["depth"] = copy_of(view.depth_m);
        const fs::path file = folder_ / frame_file_name(view.info.index);
        write_exr(file, frame);
        bytes_ += size_of(file);
    }
    void finish() override {}
    std::int64_t bytes() const override { return bytes_; }

private:
    static FloatImage with_alpha(const FloatImage& rgb, const ByteImage& origin) {
        FloatImage rgba(rgb.width(), rgb.height(), 4);
        for (int y = 0; y < rgb.height(); ++y)
            for (int x = 0; x < rgb.width(); ++x) {
                std::copy_n(rgb.pixel(x, y), 3, rgba.pixel(x, y));
                rgba.pixel(x, y)[3] = origin.pixel(x, y)[0] == std::uint8_t(PixelOrigin::gap) ? 0.0f : 1.0f;
            }
        return rgba;
    }
    static FloatImage copy_of(ImageView<const float> plane) {
        FloatImage copy(plane.width, plane.height, 1);
        for (int y = 0; y < plane.height; ++y)
            std::copy_n(plane.row(y), plane.width, copy.pixel(0, y));
        return copy;
    }

    fs::path folder_;
    DisplayTransform display_;
    std::int64_t bytes_ = 0;
};

/// High quality, so that what is judged is the stream that came in and not this one.
constexpr int video_crf = 12;

class VideoViews : public ViewWriter {
public:
    explicit VideoViews(fs::path file) : file_(std::move(file)) { require_writable_folder(file_.parent_path()); }
    void write(const FinishedView& view) override {
        if (!writer_)
            open(view);
        writer_->write(TrackRole::main, view.picture.rgb().view(), view.info);
    }
    void finish() override {
        if (writer_)
            writer_->finish();
    }
    std::int64_t bytes() const override { return writer_ ? writer_->bytes().front() : 0; }

private:
    void open(const FinishedView& view) {
        StreamSettings settings;
        settings.crf = video_crf;
        settings.frames_per_second = view.info.frames_per_second;
        settings.scene = view.info.scene;
        settings.tracks = {{TrackRole::main, view.picture.rgba.width(), view.picture.rgba.height()}};
        writer_ = std::make_unique<StreamWriter>(file_.string(), settings);
    }

    fs::path file_;
    std::unique_ptr<StreamWriter> writer_;
};

}  // namespace

std::unique_ptr<ViewWriter> make_view_writer(Format format, const fs::path& out, const std::string& name) {
    if (format == Format::png)
        return std::make_unique<PngViews>(out / name);
    if (format == Format::exr)
        return std::make_unique<ExrViews>(out / name);
    return std::make_unique<VideoViews>(out / (name + ".mp4"));
}

void find_gap_mask(const EyePicture& picture, ByteImage& mask) {
    if (mask.width() != picture.origin.width() || mask.height() != picture.origin.height())
        mask = ByteImage(picture.origin.width(), picture.origin.height(), 1);
    std::ranges::transform(picture.origin.samples(), mask.samples().begin(), [](std::uint8_t origin) {
        return origin == std::uint8_t(PixelOrigin::gap) ? std::uint8_t{255} : std::uint8_t{0};
    });
}

void require_writable_folder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    std::string why = error ? error.message() : "";
    if (!error && access(folder.c_str(), W_OK | X_OK) != 0)
        why = std::strerror(errno);
    if (!error && !fs::is_directory(folder))
        why = "not a folder";
    if (!why.empty())
        throw InputError(expected_found(folder.string(), "a folder that can be written to", why));
}

}  // namespace equistream::play
