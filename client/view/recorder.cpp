#include "recorder.h"

#include <equistream/error.h>
#include <equistream/locks.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>
#include <equistream/text.h>

#include <cstdio>

namespace equistream {

namespace {

namespace fs = std::filesystem;

/// The first of NAME.0001EXTENSION and so on that is not there yet.
fs::path unused_name(const fs::path& folder, const char* name, const char* extension) {
    constexpr int most = 10000;
    for (int i = 1; i < most; ++i)
        if (const fs::path file = folder / formatted("%s.%04d%s", name, i, extension); !fs::exists(file))
            return file;
    throw WorkError(expected_found(folder.string(), formatted("fewer than %d files %s.NNNN%s", most, name, extension),
                                   "more; move some away"));
}

}  // namespace

Recorder::~Recorder() {
    try {
        if (records_head_)
            start_or_stop_head();
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
    }
}

std::string Recorder::keep_picture(ImageView<const std::uint8_t> rgb) {
    require_writable_folder(folder_);
    const fs::path file = unused_name(folder_, "view", ".png");
    write_picture(file, rgb);
    return "wrote " + file.string();
}

std::string Recorder::start_or_stop_view() {
    if (records_view()) {
        const std::string folder = std::exchange(view_folder_, {}).string();
        return "recorded " + std::to_string(view_pictures_) + " pictures into " + folder;
    }
    require_writable_folder(folder_);
    view_folder_ = unused_name(folder_, "recording", "");
    require_writable_folder(view_folder_);
    view_pictures_ = 0;
    return "recording into " + view_folder_.string();
}

void Recorder::add_view(ImageView<const std::uint8_t> rgb) {
    if (!records_view())
        return;
    try {
        write_picture(view_folder_ / frame_file_name(view_pictures_, "png"), rgb);
        ++view_pictures_;
    } catch (...) {
        view_folder_.clear();
        throw;
    }
}

std::string Recorder::start_or_stop_head() {
    if (!records_head_) {
        require_writable_folder(folder_);
        head_.clear();
        records_head_ = true;
        return "recording the head's path";
    }
    if (!head_.empty()) {
        const fs::path file = unused_name(folder_, "head", ".csv");
        write_path_csv(file, PosePath(head_, file.string()));
        records_head_ = false;
        return "wrote " + std::to_string(head_.size()) + " poses to " + file.string();
    }
    records_head_ = false;
    return "no path was recorded";
}

void Recorder::add_head(double time_s, const Pose& head) {
    if (!records_head_)
        return;
    if (head_.empty() || time_s > head_.back().time_s)
        head_.push_back({time_s, head});
}

}  // namespace equistream
