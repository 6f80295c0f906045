// How this page reads the formulas of plugin/formulas (scalars.h has the other readings): assemble.py puts their texts
// here, as functions of plain numbers.
const abs = Math.abs, max = Math.max, min = Math.min;

function select(condition, yes, no) {
    return condition ? yes : no;
}
function both(a, b) {
    return a && b;
}
function either(a, b) {
    return a || b;
}
/// NaN for NaN.
function min_or_nan(x, most) {
    return x > most ? most : x;
}

//#formulas agreement.glsl.h wrapping.glsl.h

export {agree_inverse, are_joined, column_over_pole, column_round, row_over_pole};
