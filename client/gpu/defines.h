#pragma once
/// "#define NAME VALUE" lines of GLSL from numbers of C++, so that neither can differ from the other.
#include <equistream/text.h>

#include <span>
#include <string>
#include <utility>

namespace equistream::gl {

class Defines {
public:
    void add(const char* name, double value) {
        const std::string number = formatted("%.9g", value);
        // 1e+09 and 0.5 are numbers of GLSL's as they stand; 8 would be a whole one.
        const bool whole = number.find_first_of(".e") == std::string::npos;
        text_ += formatted("#define %s %s%s\n", name, number.c_str(), whole ? ".0" : "");
    }
    void add_whole(const char* name, int value) { text_ += formatted("#define %s %d\n", name, value); }
    void add_unsigned(const char* name, unsigned value) { text_ += formatted("#define %s %uu\n", name, value); }
    void add(const char* name, std::span<const float> values) {
        text_ += formatted("#define %s float[%d](", name, int(values.size()));
        for (std::size_t i = 0; i < values.size(); ++i)
            text_ += formatted("%s%.9g", i == 0 ? "" : ", ", double(values[i]));
        text_ += ")\n";
    }
    void add_bits(const char* name, unsigned bits) {
        text_ += formatted("#define %s uintBitsToFloat(0x%xu)\n", name, bits);
    }
    std::string take() { return std::move(text_); }

private:
    std::string text_;
};

}  // namespace equistream::gl
