// How shaders read the formulas of *.glsl.h (scalars.h). Stands before every shader's text.

#define Number float
#define Truth bool
#define FORMULA
#define CONSTANT const

float select(bool condition, float yes, float no) {
    return condition ? yes : no;
}

float with_sign_of(float magnitude, float sign_of) {
    return sign_of < 0.0 ? -magnitude : magnitude;
}
