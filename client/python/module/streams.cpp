#include "bindings.h"

#include <client/receive/receive.h>
#include <client/transport/address.h>
#include <client/transport/server_connection.h>
#include <equistream/stream.h>
#include <equistream/text.h>

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

namespace equistream::python {

namespace {

nb::object next_picture(StreamReader& reader) {
    std::optional<DecodedPicture> picture = reader.next();
    FloatImage hdr = picture && !picture->pq.empty() ? pq_to_rgb(picture->pq.planes) : FloatImage();
    const nb::gil_scoped_acquire acquire;
    if (!picture)
        return nb::none();
    nb::dict found;
    found["role"] = track_name(picture->role);
    found["info"] = picture->info ? nb::cast(*picture->info) : nb::none();
    found["rgb"] = picture->rgb.empty() ? nb::none() : nb::object(to_array(std::move(picture->rgb)));
    found["pq"] = hdr.empty() ? nb::none() : nb::object(to_array(std::move(hdr)));
    found["depth_m"] = picture->depth_m.empty() ? nb::none() : nb::object(to_array(std::move(picture->depth_m)));
    found["decode_ms"] = picture->decode_ms;
    found["convert_ms"] = picture->convert_ms;
    found["bytes"] = picture->bytes;
    return found;
}

nb::list tracks_of(const std::vector<StreamTrackSummary>& summaries) {
    nb::list tracks;
    for (const StreamTrackSummary& track : summaries) {
        nb::dict row;
        row["role"] = track_name(track.role);
        row["name"] = track.name;
        row["codec"] = track.codec;
        row["width"] = track.width;
        row["height"] = track.height;
        row["frames_per_second"] = track.frames_per_second;
        row["pixel_format"] = track.pixel_format;
        row["colour"] = track.colour;
        row["equirect"] = track.sphere.has_value();
        row["pictures"] = track.pictures;
        row["bytes"] = track.bytes;
        tracks.append(row);
    }
    return tracks;
}

/// One reader, one thread at a time: Python's own lock is given up while it works, so another thread could come in.
/// What other threads may ask meanwhile is copied after each picture, with the lock held.
class Stream {
public:
    explicit Stream(const std::string& source) {
        waiting_.run([&] {
            reader_ = std::make_unique<StreamReader>(
                without_secrets(source),
                connected(source, {.rgb = true, .pq = true, .interrupted = waiting_.question()}));
        });
        container_ = reader_->container();
        tracks_ = reader_->tracks();
    }
    nb::object next() {
        nb::object picture;
        waiting_.run([&] {
            picture = next_picture(*reader_);
            const nb::gil_scoped_acquire acquire;
            tracks_ = reader_->tracks();
            truncation_ = reader_->truncation();
        });
        return picture;
    }
    nb::list tracks() const { return tracks_of(tracks_); }
    std::string container() const { return container_; }
    std::string truncation() const { return truncation_; }

private:
    Waiting waiting_{"stream"};
    std::unique_ptr<StreamReader> reader_;
    std::vector<StreamTrackSummary> tracks_;
    std::string container_, truncation_;
};

nb::object picture_of(ReceivedPicture&& picture) {
    nb::dict found;
    found["info"] = nb::cast(picture.info);
    found["rgb"] = picture.rgb.empty() ? nb::none() : to_array(std::move(picture.rgb));
    found["yuv"] = picture.yuv.empty() ? nb::none() : to_arrays(std::move(picture.yuv));
    const auto plane = [&](const char* name, FloatImage& image) {
        found[name] = image.empty() ? nb::none() : to_array(std::move(image));
    };
    plane("depth_m", picture.depth_m);
    plane("specular", picture.specular);
    plane("virtual_depth_m", picture.virtual_depth_m);
    return found;
}

nb::object frame_of(ReceivedFrame&& frame) {
    nb::dict found;
    found["main"] = picture_of(std::move(frame.main));
    found["right"] = frame.right ? picture_of(std::move(*frame.right)) : nb::none();
    found["base"] = frame.base ? picture_of(std::move(*frame.base)) : nb::none();
    found["small"] = frame.small ? picture_of(std::move(*frame.small)) : nb::none();
    found["hidden"] = frame.hidden ? picture_of(std::move(*frame.hidden)) : nb::none();
    found["patches"] = frame.patches ? picture_of(std::move(*frame.patches)) : nb::none();
    found["posed"] = frame.posed;
    nb::list views;
    for (ReceivedPicture& view : frame.depth_views)
        views.append(picture_of(std::move(view)));
    found["depth_views"] = views;
    return found;
}

class Feed {
public:
    Feed(const std::string& source, bool depth, bool yuv, std::int64_t first, std::int64_t last) {
        waiting_.run([&] {
            feed_ = open_feed(source, {.depth = depth,
                                       .yuv = yuv,
                                       .specular = depth,
                                       .first_frame = first,
                                       .last_frame = last,
                                       .interrupted = waiting_.question()});
        });
    }
    nb::object next() {
        nb::object found = nb::none();
        waiting_.run([&] {
            std::optional<ReceivedFrame> frame = feed_->next();
            const nb::gil_scoped_acquire acquire;
            truncation_ = feed_->truncation();
            if (frame)
                found = frame_of(std::move(*frame));
        });
        return found;
    }
    std::string truncation() const { return truncation_; }

private:
    Waiting waiting_{"stream"};
    std::unique_ptr<FrameFeed> feed_;
    std::string truncation_;  ///< as of the last next(), as in Stream
};

}  // namespace

void bind_streams(nb::module_& m) {
    nb::class_<Stream>(m, "Stream")
        .def(nb::init<const std::string&>(), nb::arg("source"))
        .def("next", &Stream::next)
        .def("tracks", &Stream::tracks)
        .def("container", &Stream::container)
        .def("truncation", &Stream::truncation);
    nb::class_<Feed>(m, "Feed")
        .def(nb::init<const std::string&, bool, bool, std::int64_t, std::int64_t>(), nb::arg("source"),
             nb::arg("depth"), nb::arg("yuv"), nb::arg("first_frame"), nb::arg("last_frame"))
        .def("next", &Feed::next)
        .def("truncation", &Feed::truncation);
}

}  // namespace equistream::python
