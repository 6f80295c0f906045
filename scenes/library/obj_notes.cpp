#include "obj_notes.h"

#include <equistream/error.h>

namespace equistream {

void ObjNotes::add(const std::string& where, const std::string& text) {
    const auto [entry, added] = index_of_text_.try_emplace(text, notes_.size());
    if (added)
        notes_.push_back({where, text});
    else
        ++notes_[entry->second].more;
}

std::vector<std::string> ObjNotes::lines() const {
    std::vector<std::string> lines;
    for (const Note& note : notes_)
        lines.push_back(quotable(note.where, 4096) + ": " + quotable(note.text, 400) +
                        (note.more > 0 ? " (and " + std::to_string(note.more) + " more)" : ""));
    return lines;
}

}  // namespace equistream
