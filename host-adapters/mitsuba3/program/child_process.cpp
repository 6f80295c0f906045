#include "child_process.h"

#include <equistream/error.h>
#include <programs/cli/child.h>
#include <programs/cli/process.h>

#include <utility>

namespace equistream::mitsuba_host {
namespace {

/// "equistream scene: FILE: expected ..." without what names the program.
std::string complaint(std::string text) {
    while (!text.empty() && text.back() == '\n')
        text.pop_back();
    text = text.substr(text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1);
    const std::string prefix = "equistream scene: ";
    return text.starts_with(prefix) ? text.substr(prefix.size()) : text;
}

}  // namespace

std::string run_beside(const std::string& program, const std::vector<std::string>& arguments) {
    std::vector<std::string> words{(cli::own_folder() / program).string()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    cli::ChildEnd child = cli::run_child(words);
    if (child.is_good())
        return std::move(child.output);
    const std::string what =
        quotable(child.errors.empty() ? program + ": failed without a message" : complaint(child.errors), 900);
    if (child.exit_code == 2)
        throw InputError(what);
    throw WorkError(what);
}

}  // namespace equistream::mitsuba_host
