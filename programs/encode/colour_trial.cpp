#include "colour_trial.h"

#include "source_pictures.h"

#include <equistream/colour.h>
#include <equistream/error.h>
#include <equistream/sequence.h>
#include <programs/cli/process.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace equistream {

namespace {

constexpr std::size_t trial_frames = 8;

bool same_size(const ByteImage& a, const ByteImage& b) {
    return a.width() == b.width() && a.height() == b.height();
}

/// With references where the file has some.
std::optional<Frame> colour_frame(const Sources& sources, std::size_t position) {
    const auto file = sources.looked_at().folder / frame_file_name(sources.frames[position]);
    for (const std::vector<std::string>& planes :
         {std::vector<std::string>{"colour", "reference", "reference_repeat"}, {"colour"}})
        try {
            Frame frame = read_exr(file, planes);
            number_as_named(frame.info, sources.frames[position]);
            return frame.planes.contains("colour") ? std::optional(std::move(frame)) : std::nullopt;
        } catch (const InputError&) {
            // The plane is missing, or the file is broken.
        }
    return std::nullopt;
}

/// RGBA as VisibleLossMeter takes it.
ByteImage reference_picture(const ByteImage& rgb, const FloatImage& reference) {
    ByteImage rgba(rgb.width(), rgb.height(), 4);
    for (int y = 0; y < rgb.height(); ++y)
        for (int x = 0; x < rgb.width(); ++x) {
            std::copy_n(rgb.pixel(x, y), 3, rgba.pixel(x, y));
            rgba.pixel(x, y)[3] = reference.pixel(x, y)[3] > 0 ? 255 : 0;
        }
    return rgba;
}

/// Pictures as clients show them who ask for nothing in particular.
class AsShown {
public:
    explicit AsShown(Transfer transfer) {
        if (transfer == Transfer::pq)
            display_.emplace();
    }
    ByteImage operator()(const Picture& picture) const {
        return display_ ? of_pq(picture.pq.view()) : ByteImage(picture.rgb);
    }
    ByteImage operator()(const DecodedPicture& picture) const {
        return display_ && !picture.pq.empty() ? of_pq(pq_to_rgb(picture.pq.planes).view()) : ByteImage(picture.rgb);
    }

private:
    ByteImage of_pq(ImageView<const float> pq) const { return quantise_8bit(display_->to_display(pq).view()); }

    std::optional<HdrDisplay> display_;
};

ColourTrial try_colour(const Sources& sources, const StreamSettings& settings) {
    const TrialRange range(sources.frames.size(), settings.gop);
    const cli::ScratchFolder scratch("encode");
    const ColourCoding coding(settings.transfer);
    const AsShown shown(settings.transfer);
    std::vector<ByteImage> pictures, references, repeats;
    std::optional<StreamWriter> writer;
    for (std::size_t i = range.first; i < range.last; ++i) {
        const std::optional<Frame> frame = colour_frame(sources, i);
        if (!frame)
            break;
        Picture picture;
        coding(frame->planes.at("colour").view(), frame->info.exposure, picture);
        ByteImage rgb = shown(picture);
        if (!pictures.empty() && !same_size(rgb, pictures.front()))
            break;
        if (!writer) {
            StreamSettings tried = settings;
            tried.frames_per_second = frame->info.frames_per_second;
            tried.tracks = {{TrackRole::main, rgb.width(), rgb.height()}};
            writer.emplace(scratch.file("trial.nut"), tried);
        }
        picture.write(*writer, frame->info);
        pictures.push_back(std::move(rgb));
        ByteImage& reference = references.emplace_back();
        ByteImage& repeat = repeats.emplace_back();
        if (frame->planes.contains("reference")) {
            const auto as_coded = [&](const FloatImage& plane) {
                Picture of;
                coding(plane.view(), frame->info.exposure, of);
                return shown(of);
            };
            const FloatImage& many_samples = frame->planes.at("reference");
            reference = reference_picture(as_coded(many_samples), many_samples);
            repeat = as_coded(frame->planes.at("reference_repeat"));
        }
    }
    if (pictures.empty())
        return {};
    writer->finish();
    VisibleLossMeter meter;
    StreamReader reader(scratch.file("trial.nut"), {.pq = true});
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const auto decoded = reader.next();
        const ByteImage seen = decoded ? shown(*decoded) : ByteImage();
        if (!same_size(seen, pictures[i]))
            throw WorkError("the trial encoding of colour could not be decoded");
        meter.add(pictures[i].view(), seen.view());
        if (!references[i].empty())
            meter.add_reference(seen.view(), references[i].view(), repeats[i].view());
    }
    return {int(pictures.size()), double(writer->bytes().front()) / double(pictures.size()), meter.loss()};
}

}  // namespace

TrialRange::TrialRange(std::size_t frames, int gop) {
    const std::size_t groups = (frames + std::size_t(gop) - 1) / std::size_t(gop);
    first = groups / 2 * std::size_t(gop);
    if (frames - first < trial_frames && first > 0)
        first -= std::size_t(gop);  // the last group, cut short
    last = std::min(first + trial_frames, frames);
}

const ColourTrial& ColourTrials::get() {
    if (!made_)
        made_ = try_colour(sources_, settings_);
    return *made_;
}

}  // namespace equistream
