#include "view_writer.h"

#include <equistream/colour.h>
#include <equistream/error.h>
#include <equistream/locks.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>
#include <equistream/stream.h>

#include <algorithm>
#include <array>
#include <exception>
#include <system_error>

namespace equistream::play {

namespace fs = std::filesystem;

namespace {

std::int64_t size_of(const fs::path& file) {
    std::error_code error;
    const auto size = fs::file_size(file, error);
    return error ? 0 : std::int64_t(size);
}

/// Display-referred pictures, of an eye or of both.
class PictureWriter {
public:
    virtual ~PictureWriter() = default;
    virtual void write(ImageView<const std::uint8_t> rgb, const FrameInfo& info) = 0;
    virtual void finish() = 0;
    virtual std::int64_t bytes() const = 0;
};

class PngPictures : public PictureWriter {
public:
    explicit PngPictures(fs::path folder) : folder_(std::move(folder)) { require_writable_folder(folder_); }
    void write(ImageView<const std::uint8_t> rgb, const FrameInfo& info) override {
        const fs::path file = folder_ / frame_file_name(info.index, "png");
        write_picture(file, rgb);
        bytes_ += size_of(file);
    }
    void finish() override {}
    std::int64_t bytes() const override { return bytes_; }

private:
    fs::path folder_;
    std::int64_t bytes_ = 0;
};

/// High quality, so that what is judged is the stream that came in and not this one.
constexpr int video_crf = 12;

class VideoPictures : public PictureWriter {
public:
    VideoPictures(fs::path file, Layout layout) : file_(std::move(file)), layout_(layout) {
        require_writable_folder(file_.has_parent_path() ? file_.parent_path() : fs::path("."));
    }
    void write(ImageView<const std::uint8_t> rgb, const FrameInfo& info) override {
        if (!writer_)
            open(rgb, info);
        writer_->write(TrackRole::main, rgb, info);
    }
    void finish() override {
        if (writer_)
            writer_->finish();
    }
    std::int64_t bytes() const override { return writer_ ? writer_->bytes().front() : 0; }

private:
    void open(ImageView<const std::uint8_t> rgb, const FrameInfo& info) {
        StreamSettings settings;
        settings.crf = video_crf;
        settings.frames_per_second = info.frames_per_second;
        settings.scene = info.scene;
        settings.tracks = {{TrackRole::main, rgb.width, rgb.height}};
        settings.tagged = layout_ == Layout::files;
        if (layout_ == Layout::side_by_side)
            settings.stereo = StereoPacking::side_by_side;
        writer_ = std::make_unique<StreamWriter>(file_.string(), settings);
    }

    fs::path file_;
    Layout layout_;
    std::unique_ptr<StreamWriter> writer_;
};

std::unique_ptr<PictureWriter> make_picture_writer(const Settings& settings, const std::string& name) {
    if (settings.out_is_video)
        return std::make_unique<VideoPictures>(settings.out, settings.layout);
    if (settings.format == Format::mp4)
        return std::make_unique<VideoPictures>(settings.out / (name + ".mp4"), settings.layout);
    return std::make_unique<PngPictures>(settings.out / name);
}

/// One eye's colours.
class ColourViews : public ViewWriter {
public:
    explicit ColourViews(std::unique_ptr<PictureWriter> pictures) : pictures_(std::move(pictures)) {}
    void write(const FinishedView& view) override { pictures_->write(view.picture.rgb().view(), view.info); }
    void finish() override { pictures_->finish(); }
    std::int64_t bytes() const override { return pictures_->bytes(); }

private:
    std::unique_ptr<PictureWriter> pictures_;
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

class EachEye : public EyesWriter {
public:
    explicit EachEye(const Settings& settings)
        : left_(make_view_writer(settings, "left")), right_(make_view_writer(settings, "right")) {}
    void write(const FinishedView& left, const FinishedView& right) override {
        left_->write(left);
        right_->write(right);
    }
    void finish() override {
        std::exception_ptr problem;
        for (ViewWriter* views : {left_.get(), right_.get()}) {
            try {
                views->finish();
            } catch (...) {
                problem = std::current_exception();
            }
        }
        if (problem)
            std::rethrow_exception(problem);
    }
    std::int64_t bytes() const override { return left_->bytes() + right_->bytes(); }

private:
    std::unique_ptr<ViewWriter> left_, right_;
};

class BothInOne : public EyesWriter {
public:
    explicit BothInOne(const Settings& settings)
        : anaglyph_(settings.anaglyph), pictures_(make_picture_writer(settings, "both")) {}
    void write(const FinishedView& left, const FinishedView& right) override {
        const ByteImage left_rgb = left.picture.rgb(), right_rgb = right.picture.rgb();
        const ByteImage both = anaglyph_ != nullptr
                                   ? make_anaglyph(*anaglyph_, left_rgb.view(), right_rgb.view())
                                   : packed_eyes(StereoPacking::side_by_side, left_rgb.view(), right_rgb.view());
        pictures_->write(both.view(), left.info);
    }
    void finish() override { pictures_->finish(); }
    std::int64_t bytes() const override { return pictures_->bytes(); }

private:
    const Anaglyph* anaglyph_;  ///< null: side by side
    std::unique_ptr<PictureWriter> pictures_;
};

}  // namespace

std::unique_ptr<ViewWriter> make_view_writer(const Settings& settings, const std::string& eye) {
    if (settings.format == Format::exr)
        return std::make_unique<ExrViews>(settings.out / eye);
    return std::make_unique<ColourViews>(make_picture_writer(settings, eye));
}

std::unique_ptr<EyesWriter> make_eyes_writer(const Settings& settings) {
    if (settings.layout == Layout::files)
        return std::make_unique<EachEye>(settings);
    return std::make_unique<BothInOne>(settings);
}

}  // namespace equistream::play
