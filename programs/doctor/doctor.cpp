/// equistream doctor: what is there, what is missing, and how to get it.
#include "checks.h"

#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/text.h>
#include <programs/cli/columns.h>
#include <programs/cli/program.h>
#include <programs/cli/provenance.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace equistream;
using namespace equistream::doctor;

struct Options {
    std::string command;
    bool json = false;
    double limit_s = 30;
};

constexpr std::size_t name_columns = 11, state_columns = 9;

void print_row(const std::string& head, const std::string& text) {
    std::fputs(cli::wrapped(head, text, cli::output_columns()).c_str(), stdout);
}

std::string padded(std::string_view text, std::size_t width) {
    return std::string(text) + std::string(width - std::min(width, text.size()), ' ');
}

void print(const Check& check, const Finding& finding) {
    const std::string state = nlohmann::ordered_json(finding.state);
    print_row(padded(check.name, name_columns) + padded(state, state_columns), finding.found);
    const std::string below(name_columns + state_columns, ' ');
    if (finding.state != State::ok)
        print_row(below + "needed by: ", std::string(check.purpose));
    if (!finding.get.empty())
        print_row(below + "to get it: ", finding.get);
    std::fflush(stdout);
}

nlohmann::ordered_json row_of(const Check& check, const Finding& finding) {
    nlohmann::ordered_json json = {{"name", check.name},
                                   {"state", finding.state},
                                   {"found", finding.found},
                                   {"is_needed", check.is_needed},
                                   {"needed_by", check.purpose}};
    json["to_get_it"] = finding.get;
    json["details"] = finding.details;
    return json;
}

void run(const Options& options) {
    cli::require(options.limit_s > 0 && options.limit_s <= 3600, "--limit", "seconds, above 0 and up to 3600",
                 in_words(options.limit_s));
    Surroundings surroundings;
    surroundings.limit_s = options.limit_s;
    std::vector<std::string> faults, others;
    nlohmann::ordered_json found = nlohmann::ordered_json::array();
    for (const Check& check : all_checks()) {
        const Finding finding = found_by(check, surroundings);
        if (finding.state != State::ok)
            (check.is_needed ? faults : others).emplace_back(check.name);
        if (options.json)
            found.push_back(row_of(check, finding));
        else
            print(check, finding);
    }
    if (options.json) {
        nlohmann::ordered_json json = cli::provenance(options.command);
        json["is_ready"] = faults.empty();
        json["checks"] = std::move(found);
        std::puts(json_text(json, 2).c_str());
    }
    if (!faults.empty())
        throw WorkError("the core commands lack " + in_a_sentence(faults, " and "));
    if (options.json)
        return;
    std::puts("");
    print_row("",
              "The core commands have all that they need." +
                  (others.empty() ? "" : " Missing for optional features: " + in_a_sentence(others, " and ") + "."));
}

}  // namespace

int main(int argc, char** argv) {
    Options options;
    options.command = cli::quoted_command(argc, argv);
    return cli::run_program(
        argc, argv,
        {"doctor",
         "Say what is installed, what is missing and how to get it; status 1 where a core command lacks something",
         "equistream doctor"},
        [&](cli::CommandLine& app) -> std::function<void()> {
            cli::add_json_flag(app, options.json);
            cli::add_with_default(app, "--limit", options.limit_s,
                                  "Seconds that each program which it starts may take");
            return [&options] { run(options); };
        });
}
