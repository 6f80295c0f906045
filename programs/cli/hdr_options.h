#pragma once
/// Options on how an HDR stream comes to the display, the same in `play` and `view`.
#include "program.h"

#include <equistream/colour.h>

#include <memory>

namespace equistream {

class HdrOptions {
public:
    void add_to(CLI::App& app);
    /// Null where none was given. Throws InputError.
    std::shared_ptr<const HdrDisplay> display() const;

private:
    HdrDisplaySettings settings_;
    std::vector<CLI::Option*> options_;
};

}  // namespace equistream
