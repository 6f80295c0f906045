#include "feeds.h"

#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/sequence.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

namespace equistream {

namespace {

namespace fs = std::filesystem;

class FolderFeed : public FrameFeed {
public:
    FolderFeed(fs::path folder, const FeedOptions& options) : folder_(std::move(folder)), options_(options) {
        main_ = find_main();
        for (const std::int64_t index : list_frames(folder_ / main_))
            if (index >= options.first_frame && index <= options.last_frame)
                frames_.push_back(index);
        if (frames_.empty())
            throw InputError(expected_found((folder_ / main_).string(),
                                            options.last_frame < FeedOptions{}.last_frame
                                                ? "rendered frames in the range asked for"
                                                : "rendered frames",
                                            "none"));
        for (const char* view : {".", "centre", "left", "right", "small", "hidden", "patches", "window"})
            if (options.depth && fs::is_directory(folder_ / view) && holds(view, "depth", true))
                views_with_depth_.insert(view);
        for (const std::string& view : {main_, std::string("window")})
            for (const char* plane : {"specular", "virtual_depth"})
                if (options.specular && fs::is_directory(folder_ / view) && holds(view, plane, false))
                    image_planes_[view].push_back(plane);
    }

    std::optional<ReceivedFrame> next() override {
        if (position_ == frames_.size())
            return std::nullopt;
        left_out_ |= asked_to_leave_out(options_);
        const std::int64_t index = frames_[position_++];
        ReceivedFrame frame;
        frame.main = read(main_, index, true);
        if (is_ods(frame.main.info.camera)) {
            frame.posed = false;
            if (main_ == "left" && fs::exists(file("right", index)))
                frame.right = read_beside(frame.main.info, "right", companion_of(TrackRole::main));
            return frame;
        }
        for (auto [view, picture] :
             {std::pair{"small", &frame.small}, {"hidden", &frame.hidden}, {"patches", &frame.patches}})
            if (wants(role_of(view)) && fs::exists(file(view, index)))
                *picture = read_beside(frame.main.info, view, companion_of(role_of(view)));
        require_patches_of_main(folder_.string(), frame);
        for (const char* view : {".", "centre", "left", "right"})
            if (wants_depth_of(view) && view != main_ && fs::exists(file(view, index)))
                frame.depth_views.push_back(read_beside(frame.main.info, view, Companion::scene));
        if (wants(TrackRole::window) && fs::exists(file("window", index)))
            look_through_window(folder_.string(),
                                read_beside(frame.main.info, "window", companion_of(TrackRole::window)), frame);
        return frame;
    }

    std::string truncation() const override { return {}; }
    std::vector<FeedTrack> tracks() const override { return tracks_; }
    std::optional<double> fraction_done() const override { return double(position_) / double(frames_.size()); }
    bool is_live() const override { return false; }
    std::vector<std::string> transfers() const override { return {}; }
    FeedSummary summary() const override {
        return {.kind = "a folder of frames",
                .codec = {},
                .seconds = {},
                .frames = frames_.empty() ? 0 : frames_.back() - frames_.front() + 1};
    }
    bool seek(std::int64_t frame) override {
        position_ = std::size_t(std::ranges::lower_bound(frames_, frame) - frames_.begin());
        return true;
    }

private:
    /// As a stream's tracks are told apart.
    static TrackRole role_of(std::string_view view) {
        return view == "small"     ? TrackRole::small
               : view == "hidden"  ? TrackRole::hidden
               : view == "patches" ? TrackRole::patches
               : view == "window"  ? TrackRole::window
                                   : TrackRole::main;
    }
    bool wants(TrackRole role) const { return !left_out_[std::size_t(role)]; }
    bool wants_depth_of(const std::string& view) const {
        return views_with_depth_.contains(view) && wants(depth_role_of(role_of(view)).value_or(TrackRole::depth));
    }

    /// The main view: the first of centre, left (as in the paper) and right that holds frames, else the folder itself.
    /// Without any frames, the first of them that is there.
    std::string find_main() const {
        constexpr std::array names = {"centre", "left", "right"};
        for (const char* name : names)
            if (holds_frames(folder_ / name))
                return name;
        if (!list_frames(folder_).empty())
            return ".";
        for (const char* name : names)
            if (fs::is_directory(folder_ / name))
                return name;
        throw InputError(
            expected_found(folder_.string(), "frames, or a folder centre, left or right of them", "neither"));
    }

    /// As the manifest says; `without_one`: what is taken to be so where there is none.
    bool holds(const std::string& view, const std::string& plane, bool without_one) const {
        if (!fs::exists(folder_ / view / "manifest.json"))
            return without_one;
        const std::vector<std::string> planes = read_manifest(folder_ / view).planes;
        return std::ranges::find(planes, plane) != planes.end();
    }

    fs::path file(const std::string& view, std::int64_t index) const { return folder_ / view / frame_file_name(index); }

    ReceivedPicture read(const std::string& view, std::int64_t index, bool with_colour) {
        const fs::path path = file(view, index);
        const auto start = Clock::now();
        std::vector<std::string> planes;
        if (with_colour)
            planes.push_back("colour");
        const bool with_depth = wants_depth_of(view);
        if (with_depth)
            planes.push_back("depth");
        const auto images_role = reflections_role_of(role_of(view));
        if (const auto images = image_planes_.find(view);
            images != image_planes_.end() && with_colour && wants(*images_role))
            planes.insert(planes.end(), images->second.begin(), images->second.end());
        Frame frame = read_exr(path, planes);
        number_as_named(frame.info, index);
        renders_.try_emplace(view, folder_ / view).first->second.require(path, frame.info);
        ReceivedPicture picture;
        picture.decode_ms = milliseconds_since(start);
        picture.info = frame.info;
        if (with_depth)
            picture.depth_m = std::move(frame.planes.at("depth"));
        const auto take = [&](const char* plane, FloatImage& to) {
            if (const auto found = frame.planes.find(plane); found != frame.planes.end())
                to = std::move(found->second);
        };
        take("specular", picture.specular);
        take("virtual_depth", picture.virtual_depth_m);
        if (with_colour) {
            const auto decoded = Clock::now();
            const FloatImage& colour = frame.planes.at("colour");
            picture.rgb = quantise_8bit(display_.to_display(colour.view(), picture.info.exposure).view());
            picture.convert_ms = milliseconds_since(decoded);
        }
        std::error_code ignored;
        auto track = std::ranges::find(tracks_, view, &FeedTrack::name);
        if (track == tracks_.end())
            track = tracks_.insert(track, {view, 0, 0});
        track->pictures += 1;
        track->bytes += std::int64_t(fs::file_size(path, ignored));
        return picture;
    }

    /// Of the same render, as encode asks. Of other eyes only the depth is used, each from its own place: these need
    /// share the scene alone.
    ReceivedPicture read_beside(const FrameInfo& main, const std::string& view, Companion companion) {
        ReceivedPicture picture = read(view, main.index, companion != Companion::scene);
        require_companion(companion, folder_ / main_, main, folder_ / view, picture.info, ", or remove that folder");
        return picture;
    }

    fs::path folder_;
    FeedOptions options_;
    TrackRoles left_out_;
    DisplayTransform display_;
    std::string main_;
    std::set<std::string> views_with_depth_;
    std::map<std::string, std::vector<std::string>> image_planes_;  // of mirrors and glass, by view
    std::map<std::string, OneRender> renders_;                      // by view
    std::vector<std::int64_t> frames_;
    std::size_t position_ = 0;
    std::vector<FeedTrack> tracks_;
};

}  // namespace

std::unique_ptr<FrameFeed> open_folder_feed(const std::string& folder, const FeedOptions& options) {
    return std::make_unique<FolderFeed>(folder, options);
}

}  // namespace equistream
