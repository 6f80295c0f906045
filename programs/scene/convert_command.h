#pragma once
/// equistream scene convert SCENE.json OUT.xml.
#include <programs/cli/program.h>

namespace equistream {

struct ConvertCommand {
    CLI::App* app = nullptr;
    std::function<void()> run;  ///< once the command line has been parsed
};

ConvertCommand add_convert_command(CLI::App& app);

}  // namespace equistream
