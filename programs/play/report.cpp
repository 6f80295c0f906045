#include "report.h"

#include <equistream/text.h>
#include <programs/cli/provenance.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

namespace equistream::play {

namespace {

using Json = nlohmann::ordered_json;

/// Nearest-rank percentile of sorted samples.
double percentile(const std::vector<double>& sorted, double share) {
    const auto rank = std::size_t(std::ceil(share * double(sorted.size())));
    return sorted[std::clamp<std::size_t>(rank, 1, sorted.size()) - 1];
}

std::vector<double> sorted_samples(const std::deque<FrameFigures>& frames, std::size_t stage) {
    std::vector<double> samples;
    for (const FrameFigures& frame : frames)
        samples.insert(samples.end(), frame.milliseconds[stage].begin(), frame.milliseconds[stage].end());
    std::ranges::sort(samples);
    return samples;
}

double mean(const std::vector<double>& samples) {
    return samples.empty() ? 0 : std::accumulate(samples.begin(), samples.end(), 0.0) / double(samples.size());
}

Json summary(const std::deque<FrameFigures>& frames) {
    Json stages = Json::object();
    for (std::size_t stage = 0; stage < stage_names.size(); ++stage) {
        const std::vector<double> samples = sorted_samples(frames, stage);
        if (!samples.empty())
            stages[stage_names[stage]] = {{"p50", percentile(samples, 0.5)},
                                          {"p95", percentile(samples, 0.95)},
                                          {"p99", percentile(samples, 0.99)},
                                          {"mean", mean(samples)},
                                          {"samples", samples.size()}};
    }
    return stages;
}

/// Share of pixels that are gaps, before and after each fill pass.
Json shares(const EyeFigures& eye) {
    const double pixels = double(std::max<std::int64_t>(eye.pixels, 1));
    Json json = {{"pixels", eye.pixels}, {"gaps", eye.gaps}, {"gap_fraction", double(eye.gaps) / pixels}};
    const SpecularCounts& specular = eye.specular;
    if (specular.all() > 0)
        json["specular"] = {{"kept", specular.kept},
                            {"by_virtual_depth", specular.by_image},
                            {"displaced", specular.displaced},
                            {"gaps", specular.gaps}};
    if (eye.reliability)
        json["reliability"] = *eye.reliability;
    std::int64_t open = eye.gaps;
    json["filled"] = Json::object();
    json["gap_fraction_after"] = Json::object();
    for (const auto& [fill_pass, count] : eye.filled) {
        open -= count;
        json["filled"][fill_pass] = count;
        json["gap_fraction_after"][fill_pass] = double(open) / pixels;
    }
    return json;
}

/// Fill chains of frames may differ by fill passes that are left out.
void add_by_pass(const FilledCounts& filled, FilledCounts& sum) {
    auto place = sum.begin();
    for (const auto& [fill_pass, count] : filled) {
        const auto found = std::ranges::find(sum, fill_pass, &FilledCounts::value_type::first);
        place = found != sum.end() ? found : sum.insert(place, {fill_pass, 0});
        place->second += count;
        ++place;
    }
}

EyeFigures total(const std::deque<FrameFigures>& frames, EyeFigures FrameFigures::*eye) {
    EyeFigures sum;
    for (const FrameFigures& frame : frames) {
        const EyeFigures& figures = frame.*eye;
        if (figures.reliability)
            sum.reliability = sum.reliability.value_or(0) + *figures.reliability / double(frames.size());
        sum.pixels += figures.pixels;
        sum.gaps += figures.gaps;
        sum.specular += figures.specular;
        add_by_pass(figures.filled, sum.filled);
    }
    return sum;
}

Json plan_json(const Plan& plan) {
    return {{"method", plan.method}, {"depth", plan.depth}, {"fill", plan.fill}};
}

Json choice_json(const Choice& choice) {
    Json json = {
        {"budget_ms", choice.budget_ms}, {"frame", choice.frame}, {"fits", choice.fits}, {"line", choice.line()}};
    json["tried"] = Json::array();
    for (const auto& [plan, trial] : choice.tried) {
        Json entry = plan_json(plan);
        entry["milliseconds"] = trial.milliseconds.all;
        entry["unfilled_ms"] = trial.milliseconds.unfilled;
        entry["filled"] = Json::object();
        for (const auto& [pass, count] : trial.filled)
            entry["filled"][pass] = count;
        json["tried"].push_back(std::move(entry));
    }
    json["chosen"] = choice.chosen;
    json["passed_over"] = Json::array();
    for (const auto& [plan, at_least_ms] : choice.passed_over) {
        json["passed_over"].push_back(plan_json(plan));
        json["passed_over"].back()["at_least_ms"] = at_least_ms;
    }
    return json;
}

Json changes_json(const std::vector<Change>& changes) {
    Json json = Json::array();
    for (const Change& change : changes)
        json.push_back({{"frame", change.frame},
                        {"from", plan_json(change.from)},
                        {"to", plan_json(change.to)},
                        {"median_ms", change.median_ms},
                        {"expected_ms", cli::or_null(change.expected_ms)},
                        {"line", change.line()}});
    return json;
}

Json hdr_display_json(const HdrDisplaySettings& display) {
    return {{"ocio", display.config},
            {"display", display.display},
            {"view_transform", display.view},
            {"exposure", display.exposure_stops}};
}

/// Null: all there are.
Json frames_json(const cli::FrameRange& frames) {
    return frames.last < Settings{}.frames.last ? Json({frames.first, frames.last}) : Json();
}

}  // namespace

Json settings_json(const Settings& settings) {
    Json json = {{"source", settings.source}, {"scene", settings.scene.string()},    {"head", settings.head.string()},
                 {"fill", settings.fill},     {"reliability", settings.reliability}, {"repeat", settings.repeat}};
    json["method"] = settings.method;
    json["depth"] = settings.depth;
    json["mirrors"] = mirror_treatment_names()[std::size_t(settings.mirrors)];
    json["size"] = settings.size ? Json({settings.size->width, settings.size->height}) : Json();
    json["fov_deg"] = cli::or_null(settings.fov_deg);
    json["ipd_m"] = cli::or_null(settings.ipd_m);
    json["refresh_hz"] = cli::or_null(settings.refresh_hz);
    json["network"] = settings.network;
    json["extrapolation_limit_s"] = settings.extrapolation_limit_s;
    json["format"] = format_names[std::size_t(settings.format)];
    json["layout"] = layout_names[std::size_t(settings.layout)];
    json["anaglyph"] = settings.anaglyph != nullptr ? Json(settings.anaglyph->name) : Json();
    json["hdr_display"] = settings.hdr_display ? hdr_display_json(settings.hdr_display->settings()) : Json();
    json["frames"] = frames_json(settings.frames);
    const bool by_budget = settings.method == "auto";
    json["budget_ms"] = by_budget ? Json(settings.budget_ms) : Json();
    json["rechoose"] = by_budget ? Json(settings.rechoose) : Json();
    return json;
}

Json begun_report_json(const Settings& settings) {
    Json json = cli::provenance(settings.command);
    json["versions"] = {{"equistream", json["version"]}, {"embree", EQUISTREAM_EMBREE_VERSION}};
    json["settings"] = settings_json(settings);
    return json;
}

void Report::add(FrameFigures&& frame) {
    ++played;
    outside_head_box += frame.outside_head_box;
    lacking_depth += frame.lacks_depth;
    if (frames.size() == kept_frames)
        frames.pop_front();
    frames.push_back(std::move(frame));
}

Json Report::json() const {
    Json json = begun_report_json(settings);
    if (source && source->samples_per_pixel > 0)
        json["source"] = {{"seed", source->seed}, {"samples_per_pixel", source->samples_per_pixel}};
    json["method"] = method;
    json["depth"] = depth;
    if (!gl_driver.empty())
        json["gl_driver"] = gl_driver;
    json["fill"] = fill;
    json["mirrors"] = mirror_treatment_names()[std::size_t(settings.mirrors)];
    if (choice) {
        json["choice"] = choice_json(*choice);
        json["changes"] = changes_json(changes);
    }
    json["notes"] = notes;
    json["truncation"] = truncation;
    json["scene_load_ms"] = scene_load_ms;
    json["played"] = played;
    json["milliseconds"] = summary(frames);
    json["eyes"] = {{"left", shares(total(frames, &FrameFigures::left))},
                    {"right", shares(total(frames, &FrameFigures::right))}};
    json["bytes"] = {{"output", output_bytes}, {"input", Json::object()}};
    for (const FeedTrack& track : tracks)
        json["bytes"]["input"][track.name] = {{"bytes", track.bytes}, {"pictures", track.pictures}};
    if (viewing) {
        const std::span<const ViewedRefresh> all = viewing->refreshes;
        json["viewing"] = viewing_json(viewing->report, all.last(std::min(all.size(), kept_frames)));
    }
    if (steering)
        json["steering"] = {{"heads_sent", steering->heads_sent},
                            {"frames_made_for_them", steering->frames},
                            {"late_ms", 1e3 * steering->late_s}};
    json["frames"] = Json::array();
    for (const FrameFigures& frame : frames) {
        Json entry = {{"index", frame.index}, {"time_s", frame.time_s}, {"small", frame.has_small}};
        for (std::size_t stage = 0; stage < stage_names.size(); ++stage)
            if (!frame.milliseconds[stage].empty())
                entry["milliseconds"][stage_names[stage]] = mean(frame.milliseconds[stage]);
        if (frame.extrapolation_s > 0)
            entry["moved_on"] = {{"ms", 1e3 * frame.extrapolation_s},
                                 {"pixels", frame.moved_pixels},
                                 {"uncovered_pixels", frame.uncovered_pixels}};
        entry["left"] = shares(frame.left);
        entry["right"] = shares(frame.right);
        json["frames"].push_back(std::move(entry));
    }
    return json;
}

std::string Report::table() const {
    const char* shown = viewing ? "refreshes" : "frames";
    std::string out = formatted("%lld %s, method %s, depth %s%s\n", static_cast<long long>(played), shown,
                                method.c_str(), depth.c_str(), gl_driver.empty() ? "" : (" by " + gl_driver).c_str());
    if (played > std::int64_t(frames.size()))
        out += formatted("times and gaps: the latest %zu %s only\n", frames.size(), shown);
    if (choice)
        out += "auto: " + choice->line() + "\n";
    for (const Change& change : changes)
        out += "auto: " + change.line() + "\n";
    for (const std::string& note : notes)
        out += "note: " + note + "\n";
    out += formatted("%-12s %9s %9s %9s   ms a frame, both eyes\n", "stage", "p50", "p95", "p99");
    for (std::size_t stage = 0; stage < stage_names.size(); ++stage) {
        const std::vector<double> samples = sorted_samples(frames, stage);
        if (!samples.empty())
            out += formatted("%-12s %9.2f %9.2f %9.2f\n", stage_names[stage], percentile(samples, 0.5),
                             percentile(samples, 0.95), percentile(samples, 0.99));
    }
    for (const auto& [name, eye] : {std::pair{"left", total(frames, &FrameFigures::left)},
                                    std::pair{"right", total(frames, &FrameFigures::right)}}) {
        const double percent = 100 / double(std::max<std::int64_t>(eye.pixels, 1));
        out += formatted("%-6s gaps %7.3f %%", name, double(eye.gaps) * percent);
        for (const auto& [fill_pass, count] : eye.filled)
            out += formatted("   by %s %7.3f %%", fill_pass.c_str(), double(count) * percent);
        if (const SpecularCounts& specular = eye.specular; specular.all() > 0)
            out += formatted("   mirrors %.3f %%, of these %.1f %% gaps", double(specular.all()) * percent,
                             100 * double(specular.gaps) / double(specular.all()));
        if (eye.reliability)
            out += formatted("   reliability %.4f", *eye.reliability);
        out += "\n";
    }
    if (const auto moved = std::ranges::count_if(frames, [](const FrameFigures& f) { return f.extrapolation_s > 0; });
        moved > 0)
        out += formatted("moving objects were extrapolated in %lld refreshes, by up to %.1f ms\n",
                         static_cast<long long>(moved),
                         1e3 * std::ranges::max(frames, {}, &FrameFigures::extrapolation_s).extrapolation_s);
    if (steering)
        out +=
            formatted("head pose sent %lld times; %lld frames were rendered for poses %.1f ms before their own time\n",
                      static_cast<long long>(steering->heads_sent), static_cast<long long>(steering->frames),
                      1e3 * steering->late_s);
    for (const FeedTrack& track : tracks)
        out += formatted("%-6s %lld bytes in %lld pictures\n", track.name.c_str(), static_cast<long long>(track.bytes),
                         static_cast<long long>(track.pictures));
    if (viewing)
        out += viewing->report.table();
    return out;
}

}  // namespace equistream::play
