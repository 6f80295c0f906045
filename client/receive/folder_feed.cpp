#include "feeds.h"

#include <equistream/colour.h>
#include <equistream/error.h>
#include <equistream/sequence.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>

namespace equistream {

namespace {

namespace fs = std::filesystem;

double milliseconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

class FolderFeed : public FrameFeed {
public:
    FolderFeed(fs::path folder, const FeedOptions& options) : folder_(std::move(folder)), options_(options) {
        main_ = find_main();
        for (const std::int64_t index : list_frames(folder_ / main_))
            if (index >= options.first_frame && index <= options.last_frame)
                frames_.push_back(index);
        if (frames_.empty())
            throw InputError(
                expected_found((folder_ / main_).string(), "rendered frames in the range asked for", "none"));
        for (const char* view : {"left", "right"})
            if (options.depth && view != main_ && fs::is_directory(folder_ / view))
                depth_views_.push_back(view);
    }

    std::optional<ReceivedFrame> next() override {
        if (position_ == frames_.size())
            return std::nullopt;
        const std::int64_t index = frames_[position_++];
        ReceivedFrame frame;
        frame.main = read(main_, index, true);
        if (fs::exists(file("small", index)))
            frame.small = read("small", index, true);
        for (const std::string& view : depth_views_)
            if (fs::exists(file(view, index)))
                frame.depth_views.push_back(read(view, index, false));
        return frame;
    }

    std::string truncation() const override { return {}; }
    std::vector<FeedTrack> tracks() const override { return tracks_; }
    std::optional<double> fraction_done() const override { return double(position_) / double(frames_.size()); }

private:
    /// The main view: the head's centre, else the left eye as in the paper, else the only one there is.
    std::string find_main() const {
        for (const char* name : {"centre", "left", "right"})
            if (fs::is_directory(folder_ / name))
                return name;
        if (!list_frames(folder_).empty())
            return ".";
        throw InputError(
            expected_found(folder_.string(), "frames, or a folder centre, left or right of them", "neither"));
    }

    fs::path file(const std::string& view, std::int64_t index) const { return folder_ / view / frame_file_name(index); }

    ReceivedPicture read(const std::string& view, std::int64_t index, bool with_colour) {
        const fs::path path = file(view, index);
        const auto start = std::chrono::steady_clock::now();
        std::vector<std::string> planes;
        if (with_colour)
            planes.push_back("colour");
        if (options_.depth)
            planes.push_back("depth");
        Frame frame = read_exr(path, planes);
        ReceivedPicture picture;
        picture.decode_ms = milliseconds_since(start);
        picture.info = frame.info;
        if (options_.depth)
            picture.depth_m = std::move(frame.planes.at("depth"));
        if (with_colour)
            convert(frame.planes.at("colour"), picture);
        std::error_code ignored;
        count(view, std::int64_t(fs::file_size(path, ignored)));
        return picture;
    }

    void count(const std::string& view, std::int64_t bytes) {
        auto track = std::ranges::find(tracks_, view, &FeedTrack::name);
        if (track == tracks_.end())
            track = tracks_.insert(track, {view, 0, 0});
        track->pictures += 1;
        track->bytes += bytes;
    }

    void convert(const FloatImage& colour, ReceivedPicture& picture) const {
        const auto start = std::chrono::steady_clock::now();
        picture.rgb = quantise_8bit(display_.to_display(colour.view(), picture.info.exposure).view());
        picture.convert_ms = milliseconds_since(start);
    }

    fs::path folder_;
    FeedOptions options_;
    DisplayTransform display_;
    std::string main_;
    std::vector<std::string> depth_views_;
    std::vector<std::int64_t> frames_;
    std::size_t position_ = 0;
    std::vector<FeedTrack> tracks_;
};

}  // namespace

std::unique_ptr<FrameFeed> open_folder_feed(const std::string& folder, const FeedOptions& options) {
    return std::make_unique<FolderFeed>(folder, options);
}

}  // namespace equistream
