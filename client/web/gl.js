// Programs, textures and targets of WebGL 2.
import {StreamError} from "./bytes.js";

/// Stands before every shader. NaN is told by its bits: some drivers take it for a number.
const head = `#version 300 es
precision highp float; precision highp int;
precision highp sampler2D; precision highp usampler2D; precision highp sampler2DArray; precision highp usampler2DArray;
bool is_nan(float x) { return (floatBitsToUint(x) & 0x7fffffffu) > 0x7f800000u; }
#define isnan(x) is_nan(x)
`;

export function openGl(canvas) {
    const gl = canvas.getContext("webgl2", {alpha: false, antialias: false, depth: false, xrCompatible: true,
                                            preserveDrawingBuffer: true, powerPreference: "high-performance"});
    if (!gl)
        throw new StreamError("this browser has no WebGL 2, which this page needs");
    if (!gl.getExtension("EXT_color_buffer_float"))
        throw new StreamError(
            "this browser's WebGL cannot draw floats, which this page needs (EXT_color_buffer_float)");
    return gl;
}

export class Program {
    constructor(gl, texts, vertex, fragment, defines = []) {
        this.gl = gl;
        this.name = gl.createProgram();
        const given = defines.map(define => `#define ${define}\n`).join("");
        for (const [kind, file] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
            const shader = gl.createShader(kind);
            gl.shaderSource(shader, head + texts.reading + "\n" + given + texts[file]);
            gl.compileShader(shader);
            gl.attachShader(this.name, shader);
            if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost())
                throw new Error(`${file}: ${gl.getShaderInfoLog(shader)}`);
        }
        gl.linkProgram(this.name);
        if (!gl.getProgramParameter(this.name, gl.LINK_STATUS) && !gl.isContextLost())
            throw new Error(`${fragment}: ${gl.getProgramInfoLog(this.name)}`);
        this.uniforms = new Map();
        const count = gl.getProgramParameter(this.name, gl.ACTIVE_UNIFORMS);
        let unit = 0;
        gl.useProgram(this.name);
        for (let i = 0; i < count; ++i) {
            const {name, type} = gl.getActiveUniform(this.name, i);
            const place = gl.getUniformLocation(this.name, name);
            if (!place)
                continue;  // of a block
            const target = {[gl.SAMPLER_2D]: gl.TEXTURE_2D, [gl.UNSIGNED_INT_SAMPLER_2D]: gl.TEXTURE_2D,
                            [gl.SAMPLER_2D_ARRAY]: gl.TEXTURE_2D_ARRAY,
                            [gl.UNSIGNED_INT_SAMPLER_2D_ARRAY]: gl.TEXTURE_2D_ARRAY}[type];
            if (target)
                gl.uniform1i(place, unit);
            this.uniforms.set(name, {place, type, target, unit: target ? unit++ : -1});
        }
        ["SourceGrid", "Eyes"].forEach((block, binding) => {
            const index = gl.getUniformBlockIndex(this.name, block);
            if (index !== gl.INVALID_INDEX)
                gl.uniformBlockBinding(this.name, index, binding);
        });
    }

    /// Values by name; those that the shader does not use are passed over.
    use(values = {}) {
        const {gl} = this;
        gl.useProgram(this.name);
        for (const [name, value] of Object.entries(values)) {
            const uniform = this.uniforms.get(name);
            if (!uniform)
                continue;
            const {place, type, target, unit} = uniform;
            if (target) {
                gl.activeTexture(gl.TEXTURE0 + unit);
                gl.bindTexture(target, value);
            } else if (type === gl.FLOAT)
                gl.uniform1f(place, value);
            else if (type === gl.INT)
                gl.uniform1i(place, value);
            else if (type === gl.FLOAT_VEC2)
                gl.uniform2fv(place, value);
            else if (type === gl.INT_VEC2)
                gl.uniform2iv(place, value);
            else if (type === gl.INT_VEC3)
                gl.uniform3iv(place, value);
            else if (type === gl.INT_VEC4)
                gl.uniform4iv(place, value);
            else if (type === gl.FLOAT_MAT3)
                gl.uniformMatrix3fv(place, false, value);
        }
        return this;
    }

    /// Every pixel of what is bound.
    drawScreen() {
        this.gl.drawArrays(this.gl.TRIANGLES, 0, 3);
    }
}

function unfiltered(gl, target) {
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
        gl.texParameteri(target, side, gl.NEAREST);
    for (const edge of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T])
        gl.texParameteri(target, edge, gl.CLAMP_TO_EDGE);
}

/// `format` is a sized one. With layers, an array.
export function makeTexture(gl, format, width, height, layers = 0) {
    const texture = gl.createTexture();
    const target = layers > 0 ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D;
    gl.bindTexture(target, texture);
    if (layers > 0)
        gl.texStorage3D(target, 1, format, width, height, layers);
    else
        gl.texStorage2D(target, 1, format, width, height);
    unfiltered(gl, target);
    return texture;
}

/// Textures that a program draws into together: layers of arrays.
export class Target {
    /// parts: [{texture, layer}, ...]; null leaves one out.
    constructor(gl, width, height, parts, withDepth = false) {
        this.gl = gl;
        this.width = width;
        this.height = height;
        this.name = gl.createFramebuffer();
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.name);
        parts.forEach(({texture, layer}, i) => {
            if (layer === undefined)
                gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0);
            else
                gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, texture, 0, layer);
        });
        gl.drawBuffers(parts.map((_, i) => gl.COLOR_ATTACHMENT0 + i));
        if (withDepth) {
            this.depth = gl.createRenderbuffer();
            gl.bindRenderbuffer(gl.RENDERBUFFER, this.depth);
            gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT32F, width, height);
            gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, this.depth);
        }
    }

    bind() {
        this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, this.name);
        this.gl.viewport(0, 0, this.width, this.height);
    }

    free() {
        this.gl.deleteFramebuffer(this.name);
        if (this.depth)
            this.gl.deleteRenderbuffer(this.depth);
    }
}
