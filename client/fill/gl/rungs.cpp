#include "rungs.h"

#include <equistream/comma_list.h>
#include <equistream/error.h>

#include <algorithm>

namespace equistream::gl {

std::vector<Rung> parse_rungs(const std::string& list) {
    std::vector<Rung> rungs;
    if (list == "none")
        return rungs;
    for (const std::string_view word : split_at_commas(list)) {
        const auto found = std::ranges::find(rung_names, word);
        if (found == rung_names.end())
            throw InputError(expected_found("--fill", in_a_sentence(rung_names, " or ") + ", or none alone",
                                            "'" + std::string(word) + "'"));
        rungs.push_back(Rung(found - rung_names.begin()));
    }
    return rungs;
}

}  // namespace equistream::gl
