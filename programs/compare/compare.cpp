/// `equistream compare`: scores pictures against the truth.
#include <client/compare/comparison_report.h>
#include <client/compare/unbiased_error.h>
#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/sequence.h>
#include <equistream/text.h>
#include <programs/cli/paths.h>
#include <programs/cli/program.h>
#include <programs/cli/provenance.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <mutex>

namespace {

using namespace equistream;

struct Arguments {
    std::string command;
    PairingOptions pairing;
    ComparisonOptions comparison;
    std::vector<std::filesystem::path> second;
    std::filesystem::path truth2;
    std::string metrics = "psnr,ssim";
    std::string eyes;
    std::optional<cli::FrameRange> frames;
    std::string progress = "auto";
    std::filesystem::path gaps;
    std::filesystem::path out;
    bool json = false;
};

void choose_metrics(const std::string& list, ComparisonOptions& options) {
    options.psnr = options.ssim = options.sphere_psnr = options.flicker = false;
    for (const std::string_view word : split_at_commas(list)) {
        if (word == "psnr")
            options.psnr = true;
        else if (word == "ssim")
            options.ssim = true;
        else if (word == "ws-psnr")
            options.sphere_psnr = true;
        else if (word == "flicker")
            options.flicker = true;
        else if (word != "none" || list != "none")
            throw InputError(
                expected_found("--metrics", "psnr, ssim, ws-psnr, flicker (or none)", "'" + std::string(word) + "'"));
    }
}

void choose_second_run(Arguments& arguments) {
    const std::vector<std::filesystem::path>& second = arguments.second;
    const std::filesystem::path& truth2 = arguments.truth2;
    PairingOptions& pairing = arguments.pairing;
    if (!second.empty()) {
        pairing.second_picture = second[0];
        pairing.second_truth = second[1];
    }
    if (!truth2.empty()) {
        cli::require(second.empty() || second[1] == truth2, "--truth2", "the TRUTH2 of --second", truth2.string());
        pairing.second_truth = truth2;
        arguments.comparison.whole = true;
    }
    cli::require(!arguments.comparison.flicker || pairing.second_truth, "--metrics flicker", "--truth2 or --second",
                 "neither: a single truth's noise flickers too");
}

void complete(Arguments& arguments) {
    choose_metrics(arguments.metrics, arguments.comparison);
    if (!arguments.eyes.empty())
        for (const std::string_view eye : split_at_commas(arguments.eyes))
            arguments.pairing.eyes.emplace_back(eye);
    if (arguments.frames) {
        arguments.pairing.first_frame = arguments.frames->first;
        arguments.pairing.last_frame = arguments.frames->last;
    }
    choose_second_run(arguments);
    if (!arguments.gaps.empty())
        arguments.pairing.gaps = arguments.gaps;
    if (const auto& exposure = arguments.comparison.exposure)
        cli::require(*exposure > 0, "--exposure", "a number above 0", std::to_string(*exposure));
    if (!arguments.out.empty())
        cli::require_writable_file(arguments.out);
}

bool is_linear(const PicturePair& pair) {
    return std::ranges::any_of(std::array{&pair.picture, &pair.truth, &pair.second_picture, &pair.second_truth},
                               [](const std::filesystem::path* file) { return file->extension() == ".exr"; });
}

/// PNG is what a display was sent: no exposure and no view make it another.
void require_use_of_display(const cli::CommandLine& app, const std::vector<EyePairs>& eyes) {
    const bool any_linear =
        std::ranges::any_of(eyes, [](const EyePairs& eye) { return std::ranges::any_of(eye.pairs, is_linear); });
    for (const char* option : {"--exposure", "--view"})
        cli::require(any_linear || !app.is_given(option), option, "an EXR among the pictures", "PNG alone");
}

nlohmann::ordered_json report(const Arguments& arguments, const std::vector<EyeScore>& scores) {
    nlohmann::ordered_json json = cli::provenance(arguments.command);
    json["picture"] = arguments.pairing.picture.string();
    json["truth"] = arguments.pairing.truth.string();
    const auto path_or_null = [](const std::optional<std::filesystem::path>& path) {
        return path ? nlohmann::ordered_json(path->string()) : nlohmann::ordered_json(nullptr);
    };
    json["second_picture"] = path_or_null(arguments.pairing.second_picture);
    json["second_truth"] = path_or_null(arguments.pairing.second_truth);
    json.update(comparison_json(scores, arguments.comparison));
    return json;
}

/// No other file makes way.
void require_earlier_report(const std::filesystem::path& file) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error))
        return;
    std::ifstream text(file);
    const nlohmann::json there = nlohmann::json::parse(text, nullptr, false);
    cli::require(there.is_object() && there.contains("truth") && there.contains("eyes"), "--out " + file.string(),
                 "a new name, or an earlier report of compare to replace",
                 "another file; choose another name, or remove that file");
}

void compare(Arguments& arguments, const cli::CommandLine& app) {
    complete(arguments);
    const std::vector<EyePairs> eyes = pair_pictures(arguments.pairing);
    if (!arguments.out.empty())
        for (const EyePairs& eye : eyes)
            for (const PicturePair& pair : eye.pairs)
                for (const std::filesystem::path& read :
                     {pair.picture, pair.truth, pair.second_picture, pair.second_truth, pair.gaps})
                    if (!read.empty())
                        cli::require_not_read("--out", arguments.out, {read, report_of_views(read)});
    require_earlier_report(arguments.out);
    require_use_of_display(app, eyes);
    std::size_t pictures = 0;
    for (const EyePairs& eye : eyes)
        pictures += eye.pairs.size();
    std::vector<EyeScore> scores;
    {
        cli::Progress progress("comparing", static_cast<double>(pictures), cli::parse_progress(arguments.progress));
        std::mutex mutex;
        int done = 0;
        for (const EyePairs& eye : eyes)
            scores.push_back(compare_eye(eye, arguments.comparison, [&] {
                const std::lock_guard lock(mutex);
                ++done;
                progress.step(done, "picture " + std::to_string(done));
            }));
    }
    const std::string json = json_text(report(arguments, scores), 2) + "\n";
    if (arguments.json)
        std::fputs(json.c_str(), stdout);
    else
        std::fputs(comparison_table(scores, arguments.comparison).c_str(), stdout);
    // What was measured is told first: a full disk must not cost it.
    if (!arguments.out.empty())
        write_file_atomically(arguments.out, json);
}

std::function<void()> set_up(cli::CommandLine& app, const std::shared_ptr<Arguments>& arguments) {
    app.add_option("A", arguments->pairing.picture,
                   "What is scored: a folder with left/ and right/, a folder of frames, or one PNG or EXR")
        .required();
    app.add_option("TRUTH", arguments->pairing.truth, "What it should be, of the same kind").required();
    app.add_option("--second", arguments->second,
                   "A2 TRUTH2: a second run whose noise is independent of A's and TRUTH's; gives the noise-free error")
        .expected(2)
        .type_name("A2 TRUTH2");
    app.add_option("--truth2", arguments->truth2,
                   "A second truth, of another seed than TRUTH and A; gives the whole error, which counts A's noise "
                   "and not the truth's")
        .type_name("TRUTH2");
    cli::add_with_default(app, "--metrics", arguments->metrics,
                          "Comma-separated: psnr, ssim, ws-psnr, flicker (needs --truth2 or --second); or none");
    app.add_option("--eyes", arguments->eyes,
                   "Comma-separated: left, right, centre, small (default: left and right where they exist)");
    cli::add_frames_option(app, arguments->frames, "FIRST-LAST or one number (default: all, the same on all sides)");
    app.add_option("--exposure", arguments->comparison.exposure, "For EXR, instead of each frame's own exposure");
    cli::add_with_default(app, "--view", arguments->comparison.view, "Display view for EXR (OpenColorIO)");
    app.add_option("--gaps", arguments->gaps,
                   "Folder of gap masks as play writes them: their pixels are scored apart too");
    app.add_option("--difference", arguments->comparison.difference_folder,
                   "Folder for difference pictures alone, 8 times amplified");
    app.add_option("--out", arguments->out, "Write the report to this JSON file too; an earlier one is replaced");
    cli::add_json_flag(app, arguments->json);
    cli::add_progress_option(app, arguments->progress);
    return [arguments, &app] { compare(*arguments, app); };
}

}  // namespace

int main(int argc, char** argv) {
    auto arguments = std::make_shared<Arguments>();
    arguments->command = cli::quoted_command(argc, argv);
    return cli::run_program(argc, argv,
                            {"compare", "Score pictures against the truth: PSNR, SSIM, whole and noise-free error.",
                             "equistream compare views/sphere-left truth/seed2 --json --out score.json"},
                            [&](cli::CommandLine& app) { return set_up(app, arguments); });
}
