#include "comparison_report.h"

#include <equistream/text.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace equistream {

namespace {

using nlohmann::ordered_json;

std::string fixed(double value, int digits) {
    return formatted("%.*f", digits, value);
}

std::string decibel_text(double db) {
    if (std::isnan(db))
        return "-";
    return std::isinf(db) ? "identical" : fixed(db, 2) + " dB";
}

std::string similarity_text(const SimilaritySum& similarity) {
    return similarity.windows > 0 ? fixed(similarity.mean(), 4) : "-";
}

/// JSON has no infinity and no NaN.
ordered_json finite_or_null(double value) {
    return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

ordered_json mean_or_null(const SimilaritySum& similarity) {
    return similarity.windows > 0 ? ordered_json(similarity.mean()) : ordered_json(nullptr);
}

/// Rows of cells with columns padded to their widest cell; the first row is the heading.
std::string aligned(const std::vector<std::vector<std::string>>& rows) {
    std::vector<std::size_t> widths(rows.front().size(), 0);
    for (const auto& row : rows)
        for (std::size_t c = 0; c < row.size(); ++c)
            widths[c] = std::max(widths[c], row[c].size());
    std::string text;
    for (const auto& row : rows) {
        std::string line;
        for (std::size_t c = 0; c < row.size(); ++c)
            line += row[c] + std::string(widths[c] - row[c].size() + 2, ' ');
        text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
    }
    return text;
}

bool any_gaps(const std::vector<EyeScore>& eyes) {
    return std::any_of(eyes.begin(), eyes.end(), [](const EyeScore& eye) { return eye.pooled.gap_error.samples > 0; });
}

std::vector<std::vector<std::string>> score_rows(const std::vector<EyeScore>& eyes, const ComparisonOptions& options) {
    std::vector<std::vector<std::string>> rows{{"eye", "frames", "size"}};
    const auto head = [&](const char* title) { rows.front().emplace_back(title); };
    if (options.psnr)
        for (const char* title : {"PSNR pooled", "PSNR mean", "worst 1 %"})
            head(title);
    if (options.ssim)
        head("SSIM");
    if (options.sphere_psnr)
        head("WS-PSNR");
    if (any_gaps(eyes))
        for (const char* title : {"gaps", "PSNR in gaps", "SSIM in gaps"})
            head(title);
    for (const EyeScore& eye : eyes) {
        std::vector<std::string> row{eye.eye, std::to_string(eye.frames.size()),
                                     std::to_string(eye.width) + "x" + std::to_string(eye.height)};
        if (options.psnr)
            row.insert(row.end(), {decibel_text(eye.pooled.error.psnr_db()), decibel_text(eye.mean_frame_psnr_db()),
                                   decibel_text(eye.worst_pixels.psnr_db())});
        if (options.ssim)
            row.push_back(similarity_text(eye.pooled.similarity.all));
        if (options.sphere_psnr)
            row.push_back(decibel_text(eye.pooled.sphere_error.psnr_db()));
        if (any_gaps(eyes))
            row.insert(row.end(),
                       {fixed(100 * eye.pooled.gap_error.samples / eye.pooled.error.samples, 2) + " %",
                        decibel_text(eye.pooled.gap_error.psnr_db()), similarity_text(eye.pooled.similarity.masked)});
        rows.push_back(std::move(row));
    }
    return rows;
}

/// JSON key, what the table says, and the figures of an eye.
struct Kind {
    const char* key;
    const char* title;
    UnbiasedErrors EyeScore::*errors;
};
constexpr std::array kinds{Kind{"whole", "whole", &EyeScore::whole},
                           Kind{"noise_free", "noise-free", &EyeScore::noise_free}};

std::vector<std::vector<std::string>> unbiased_rows(const std::vector<EyeScore>& eyes, const Kind& kind,
                                                    const ComparisonOptions& options) {
    const std::string title = kind.title;
    std::vector<std::vector<std::string>> rows{
        {"eye", title + ", linear", title + ", display", title + ", linear, worst 1 %"}};
    if (any_gaps(eyes))
        rows.front().push_back(title + ", linear, in gaps");
    if (options.flicker)
        rows.front().push_back(title + ", display, flicker");
    for (const EyeScore& eye : eyes) {
        const UnbiasedErrors& errors = eye.*kind.errors;
        rows.push_back({eye.eye, unbiased_text(errors.all->linear), unbiased_text(errors.all->display),
                        unbiased_text(errors.worst->linear)});
        if (any_gaps(eyes))
            rows.back().push_back(errors.gaps ? unbiased_text(errors.gaps->linear) : "-");
        if (options.flicker)
            rows.back().push_back(errors.flicker ? unbiased_text(errors.flicker->display) : "-");
    }
    return rows;
}

ordered_json frame_json(const FrameScore& frame, const ComparisonOptions& options) {
    ordered_json json;
    json["frame"] = frame.frame ? ordered_json(*frame.frame) : ordered_json(nullptr);
    json["identical"] = frame.error.sum == 0;
    if (options.psnr)
        json["psnr_db"] = finite_or_null(frame.error.psnr_db());
    if (options.ssim)
        json["ssim"] = mean_or_null(frame.similarity.all);
    if (options.sphere_psnr)
        json["ws_psnr_db"] = finite_or_null(frame.sphere_error.psnr_db());
    if (frame.gap_error.samples > 0)
        json["gap_psnr_db"] = finite_or_null(frame.gap_error.psnr_db());
    return json;
}

ordered_json unbiased_json(const UnbiasedError& error) {
    return {{"mean_square", error.mean_square},
            {"mean_square_low", error.low},
            {"mean_square_high", error.high},
            {"db", finite_or_null(UnbiasedError::decibels(error.mean_square))},
            {"db_low", finite_or_null(UnbiasedError::decibels(error.high))},
            {"db_high", finite_or_null(UnbiasedError::decibels(error.low))},
            {"only_bounded", error.only_bounded()},
            {"confidence", 0.95},
            {"samples", error.samples},
            {"blocks", error.blocks}};
}

ordered_json unbiased_json(const ScaleErrors& errors) {
    return {{"linear", unbiased_json(errors.linear)}, {"display", unbiased_json(errors.display)}};
}

/// null where no frame follows another.
ordered_json flicker_json(const EyeScore& eye) {
    ordered_json json;
    for (const Kind& kind : kinds)
        if (const auto& flicker = (eye.*kind.errors).flicker)
            json[kind.key] = unbiased_json(*flicker);
    if (!json.is_null())
        json["motion"] = eye.flicker_by_motion ? "exact" : "none";
    return json;
}

void add_unbiased(const EyeScore& eye, const Kind& kind, ordered_json& json) {
    const UnbiasedErrors& errors = eye.*kind.errors;
    if (errors.gaps)
        json["gaps"][kind.key] = unbiased_json(*errors.gaps);
    if (errors.all)
        json[kind.key] = unbiased_json(*errors.all);
    if (errors.worst)
        json[std::string(kind.key) + "_worst_percent"] = unbiased_json(*errors.worst);
}

ordered_json eye_json(const EyeScore& eye, const ComparisonOptions& options) {
    const ErrorSum& error = eye.pooled.error;
    ordered_json json{{"width", eye.width}, {"height", eye.height}, {"frames", eye.frames.size()}};
    json["identical"] = error.sum == 0;
    if (options.psnr) {
        json["mean_square"] = error.mean_square();
        json["psnr_db"] = finite_or_null(error.psnr_db());
        json["psnr_mean_of_frames_db"] = finite_or_null(eye.mean_frame_psnr_db());
        json["psnr_worst_percent_db"] = finite_or_null(eye.worst_pixels.psnr_db());
    }
    if (options.ssim)
        json["ssim"] = mean_or_null(eye.pooled.similarity.all);
    if (options.sphere_psnr)
        json["ws_psnr_db"] = finite_or_null(eye.pooled.sphere_error.psnr_db());
    if (eye.pooled.gap_error.samples > 0)
        json["gaps"] = {{"fraction", eye.pooled.gap_error.samples / error.samples},
                        {"psnr_db", finite_or_null(eye.pooled.gap_error.psnr_db())},
                        {"ssim", mean_or_null(eye.pooled.similarity.masked)}};
    for (const Kind& kind : kinds)
        add_unbiased(eye, kind, json);
    if (options.flicker)
        json["flicker"] = flicker_json(eye);
    for (const FrameScore& frame : eye.frames)
        json["per_frame"].push_back(frame_json(frame, options));
    return json;
}

}  // namespace

std::string unbiased_text(const UnbiasedError& error) {
    if (error.mean_square == 0 && error.low == error.high)
        return "identical";
    if (error.high <= 0)
        return "none found";
    const double least = UnbiasedError::decibels(error.high);
    if (error.only_bounded())
        return "> " + fixed(least, 2) + " dB";
    return fixed(UnbiasedError::decibels(error.mean_square), 2) + " dB [" + fixed(least, 2) + ", " +
           fixed(UnbiasedError::decibels(error.low), 2) + "]";
}

std::string comparison_table(const std::vector<EyeScore>& eyes, const ComparisonOptions& options) {
    std::string text = aligned(score_rows(eyes, options));
    bool any = false;
    for (const Kind& kind : kinds)
        if ((eyes.front().*kind.errors).all) {
            text += "\n" + aligned(unbiased_rows(eyes, kind, options));
            any = true;
        }
    if (any)
        text += "95 % confidence intervals in brackets\n";
    if (!flicker_json(eyes.front()).is_null())
        text += eyes.front().flicker_by_motion ? "flicker along the truth's motion\n"
                                               : "flicker of each pixel: the truth has no motion\n";
    return text;
}

ordered_json comparison_json(const std::vector<EyeScore>& eyes, const ComparisonOptions& options) {
    ordered_json json;
    json["view"] = options.view;
    json["exposure"] = options.exposure ? ordered_json(*options.exposure) : ordered_json("each frame's own");
    for (const EyeScore& eye : eyes)
        json["eyes"][eye.eye] = eye_json(eye, options);
    return json;
}

}  // namespace equistream
