// Frames into what eyes see: the engine `mesh`, or `rotation` without depth; then the passes `base` and `pushpull`.
import {expectedFound} from "./bytes.js";
import {Program, Target, makeTexture} from "./gl.js";
import {distanceBetween, eyeBlock, eyeBlockFloats, gridBlock, halfAngleOf} from "./eye.js";
import {conjugate, minus, rotate} from "./poses.js";

/// Nearer surfaces are not drawn: the depth buffer's range begins here, metres.
const nearPlane = 0.02;
/// Cells of the pyramid's first levels lie in squares of pixels.
const squareLevels = 3;

/// A picture of the stream on the card: its colour, its distances, its mesh.
class SourcePicture {
    constructor(renderer) {
        this.renderer = renderer;
        this.size = "";
    }

    sizeFor(width, height) {
        const {gl} = this.renderer, size = `${width}x${height}`;
        if (size === this.size)
            return;
        this.free();
        this.size = size;
        this.planes = [[width, height], [width / 2, height / 2], [width / 2, height / 2]].map(
            ([w, h]) => makeTexture(gl, gl.R8UI, w, h));
        this.colour = makeTexture(gl, gl.RGBA8, width, height);
        this.target = new Target(gl, width, height, [{texture: this.colour}]);
        this.distances = makeTexture(gl, gl.R32F, width, height);
        this.mesh = gl.createVertexArray();
        this.points = gl.createBuffer();
        this.indices = gl.createBuffer();
    }

    free() {
        const {gl} = this.renderer;
        if (!this.size)
            return;
        for (const texture of [...this.planes, this.colour, this.distances])
            gl.deleteTexture(texture);
        this.target.free();
        gl.deleteVertexArray(this.mesh);
        gl.deleteBuffer(this.points);
        gl.deleteBuffer(this.indices);
        this.size = "";
    }

    set(view) {
        const {gl, programs} = this.renderer, {picture, info} = view;
        this.sizeFor(picture.width, picture.height);
        this.view = view;
        this.info = info;
        this.hasMesh = false;
        gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
        picture.planes.forEach(({data, stride}, i) => {
            const divided = i === 0 ? 1 : 2;
            gl.pixelStorei(gl.UNPACK_ROW_LENGTH, stride);
            gl.bindTexture(gl.TEXTURE_2D, this.planes[i]);
            gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, picture.width / divided, picture.height / divided, gl.RED_INTEGER,
                             gl.UNSIGNED_BYTE, data);
        });
        gl.pixelStorei(gl.UNPACK_ROW_LENGTH, 0);
        this.target.bind();
        const [luma, cb, cr] = this.planes;
        programs.decodedColour.use({luma, cb, cr}).drawScreen();
        if (!view.distances)
            return;
        gl.bindTexture(gl.TEXTURE_2D, this.distances);
        gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, picture.width, picture.height, gl.RED, gl.FLOAT, view.distances);
    }

    setMesh({points, indices}) {
        const {gl} = this.renderer;
        gl.bindVertexArray(this.mesh);
        gl.bindBuffer(gl.ARRAY_BUFFER, this.points);
        gl.bufferData(gl.ARRAY_BUFFER, points, gl.STREAM_DRAW);
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.indices);
        gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STREAM_DRAW);
        gl.enableVertexAttribArray(0);
        gl.vertexAttribPointer(0, 4, gl.FLOAT, false, 0, 0);
        gl.vertexAttribI4ui(1, 0, 0, 0, 0);
        gl.bindVertexArray(null);
        this.indexCount = indices.length;
        this.hasMesh = true;  // of a window that nobody looks at, an empty one
    }

    get hasDepth() {
        return Boolean(this.view.distances);
    }
}

/// An eye's picture on its way.
class EyePicture {
    constructor(gl, width, height) {
        this.colour = makeTexture(gl, gl.RGBA8, width, height, 1);
        this.origin = makeTexture(gl, gl.R8UI, width, height, 1);
        this.depth = makeTexture(gl, gl.R32F, width, height, 1);
        this.target = new Target(gl, width, height, [this.colour, this.origin, this.depth].map(
            texture => ({texture, layer: 0})));
    }

    free(gl) {
        for (const texture of [this.colour, this.origin, this.depth])
            gl.deleteTexture(texture);
        this.target.free();
    }
}

/// Targets of one size of view.
class EyeTargets {
    constructor(gl, width, height, eyes) {
        this.gl = gl;
        this.key = `${width}x${height}x${eyes}`;
        this.found = makeTexture(gl, gl.R32F, width, height, 1);
        this.finding = new Target(gl, width, height, [{texture: this.found, layer: 0}], true);
        this.pictures = [0, 1, 2].map(() => new EyePicture(gl, width, height));
        this.gapDepth = makeTexture(gl, gl.R32F, width, height, 1);
        this.gapTarget = new Target(gl, width, height, [{texture: this.gapDepth, layer: 0}]);
        this.shown = Array.from({length: eyes}, () => makeTexture(gl, gl.RGBA8, width, height, 1));
        this.showing = this.shown.map(texture => new Target(gl, width, height, [{texture, layer: 0}]));
        const columns = Math.ceil(width / (1 << squareLevels)), rows = Math.ceil(height / (1 << squareLevels));
        this.squares = [0, 1].map(() => makeTexture(gl, gl.R8UI, columns, rows));
        this.squareTargets = this.squares.map(texture => new Target(gl, columns, rows, [{texture}]));
        this.levels = [];
        for (let shift = squareLevels - 1; shift >= 0; --shift)
            this.addLevel(columns << shift, rows << shift);
        for (let w = columns, h = rows; w > 1 || h > 1;)
            this.addLevel(w = (w + 1) >> 1, h = (h + 1) >> 1);
    }

    addLevel(columns, rows) {
        const {gl} = this, layers = [0, 1].map(() => makeTexture(gl, gl.RGBA32F, columns, rows, 2));
        const [pulled, pushed] = layers.map(texture => new Target(gl, columns, rows, [0, 1].map(
            layer => ({texture, layer}))));
        this.levels.push({columns, rows, layers, pulled, pushed});
    }

    free() {
        const {gl} = this;
        for (const picture of this.pictures)
            picture.free(gl);
        const textures = [this.found, this.gapDepth, ...this.shown, ...this.squares,
                          ...this.levels.flatMap(level => level.layers)];
        for (const texture of textures)
            gl.deleteTexture(texture);
        const targets = [this.finding, this.gapTarget, ...this.showing, ...this.squareTargets,
                         ...this.levels.flatMap(level => [level.pulled, level.pushed])];
        for (const target of targets)
            target.free();
    }
}

export class Renderer {
    constructor(gl, texts, numbers) {
        this.gl = gl;
        this.numbers = numbers;
        this.largestSide = gl.getParameter(gl.MAX_TEXTURE_SIZE);
        const screen = (file, ...defines) => new Program(gl, texts, "screen_vertex", file, defines);
        this.programs = {
            decodedColour: screen("decoded_colour"),
            mesh: new Program(gl, texts, "mesh_vertex", "mesh_fragment", [`NEAR_PLANE_M ${nearPlane}`]),
            byDepth: screen("eye_colour", "BY_SURFACE true", "ONLY_SEEN true"),
            byDirection: screen("eye_colour", "BY_SURFACE false", "ONLY_SEEN false"),
            aroundWindow: screen("around_window"),
            gapDepth: screen("gap_depth"),
            gapSquares: screen("gap_squares"),
            squaresBeside: screen("gap_squares", "BESIDE"),
            pullPixels: screen("pull", "OF_PIXELS"),
            pull: screen("pull"),
            push: screen("push"),
            pushPixels: screen("push", "OF_PIXELS"),
            show: screen("show"),
        };
        this.main = new SourcePicture(this);
        this.window = new SourcePicture(this);
        this.current = null;  // EyeTargets
        this.others = [];     // of eyes of other sizes, of which a headset may have two
        this.blocks = [48, 4 * eyeBlockFloats * 8].map((bytes, binding) => {
            const buffer = gl.createBuffer();
            gl.bindBufferBase(gl.UNIFORM_BUFFER, binding, buffer);
            gl.bufferData(gl.UNIFORM_BUFFER, bytes, gl.DYNAMIC_DRAW);
            return buffer;
        });
        this.empty = gl.createVertexArray();
        gl.disable(gl.DITHER);
    }

    setFrame(frame) {
        const {gl} = this;
        gl.bindVertexArray(this.empty);
        gl.disable(gl.DEPTH_TEST);
        this.main.set(frame.main);
        this.hasWindow = Boolean(frame.window);
        if (this.hasWindow)
            this.window.set(frame.window);
    }

    /// Before a frame is set: whether the card has room for its pictures.
    checkSizes(frame) {
        for (const {picture: {width, height}} of [frame.main, frame.window].filter(Boolean))
            if (Math.max(width, height) > this.largestSide)
                throw expectedFound("this browser's graphics", `pictures of at most ${this.largestSide} pixels a side`,
                                    `${width}x${height} (render --size has less)`);
    }

    /// What is shown by depth: the window, if there is one, and the sphere.
    get sources() {
        return this.hasWindow ? [this.window, this.main] : [this.main];
    }

    /// What the mesh of a frame's picture must be made for so that these eyes see it: null where none is needed, or the
    /// one that was made for `made` will do. Directions may differ by what mesh.js builds beyond them.
    missingMesh(picture, made, view, eyes, exact) {
        const {pose, boxRadius} = picture.info, {meshBudgetPx, meshShare} = this.numbers;
        if (!picture.distances || eyes.every(eye => distanceBetween(eye, pose) < 1e-9))
            return null;
        const farthest = Math.max(...eyes.map(eye => distanceBetween(eye, pose)));
        // Rounded up, so that a mesh lasts for more than a step outside the box.
        const radius = exact || farthest <= boxRadius ? Math.max(boxRadius, farthest) : 1.25 * farthest;
        const error = meshBudgetPx / view.focal;
        const bound = {boxRadius: radius, tolerance: Math.sin(error), share: 0.5 * Math.sin(meshShare * error)};
        const directions = eyes.map(({orientation}) =>
            rotate(conjugate(pose.orientation), rotate(orientation, [0, 0, -1])));
        const seen = {directions, halfAngle: halfAngleOf(view), distance: farthest};
        const looksThere = made && directions.every((direction, i) => {
            const before = made.seen.directions[i] ?? made.seen.directions[0];
            return Math.hypot(...minus(direction, before)) < 0.15;
        });
        const isGood = made && made.bound.tolerance === bound.tolerance && seen.halfAngle <= made.seen.halfAngle &&
            (exact ? made.bound.boxRadius === radius : made.bound.boxRadius >= farthest) &&
            seen.distance <= made.seen.distance + 0.05 && looksThere;
        return isGood ? null : {bound, seen};
    }

    targetsOf(view, eyes) {
        const key = `${view.width}x${view.height}x${eyes}`;
        if (this.current?.key === key)
            return this.current;
        const kept = this.others.find(targets => targets.key === key);
        this.others = this.others.filter(targets => targets !== kept);
        if (this.current)
            this.others.push(this.current);
        if (this.others.length > 1)
            this.others.shift().free();
        return this.current = kept ?? new EyeTargets(this.gl, view.width, view.height, eyes);
    }

    setBlock(binding, data) {
        const {gl} = this;
        gl.bindBuffer(gl.UNIFORM_BUFFER, this.blocks[binding]);
        gl.bufferSubData(gl.UNIFORM_BUFFER, 0, data);
        gl.bindBufferBase(gl.UNIFORM_BUFFER, binding, this.blocks[binding]);
    }

    setEye(view, eye, source, budgetPx) {
        this.setBlock(1, eyeBlock(view, eye, source.info.pose, source.info.boxRadius, Math.sin(budgetPx / view.focal)));
    }

    /// 1 / planar depth of what the eye sees of a source's mesh.
    drawMesh(source, view, targets) {
        const {gl, programs} = this;
        targets.finding.bind();
        gl.enable(gl.DEPTH_TEST);
        gl.depthMask(true);
        gl.depthFunc(gl.GREATER);
        gl.clearDepth(0);
        gl.clear(gl.DEPTH_BUFFER_BIT);
        gl.clearBufferfv(gl.COLOR, 0, [NaN, NaN, NaN, NaN]);
        gl.enable(gl.CULL_FACE);
        gl.cullFace(gl.BACK);
        gl.frontFace(gl.CCW);
        programs.mesh.use({eye_size: [view.width, view.height]});
        gl.bindVertexArray(source.mesh);
        gl.drawElements(gl.TRIANGLES, source.indexCount, gl.UNSIGNED_INT, 0);
        gl.bindVertexArray(this.empty);
        gl.disable(gl.CULL_FACE);
        gl.disable(gl.DEPTH_TEST);
    }

    /// Of one source; gaps where it does not show what the eye sees.
    reproject(source, view, eye, targets, picture) {
        const byDepth = source.hasDepth && source.hasMesh && distanceBetween(eye, source.info.pose) >= 1e-9;
        const {budgetPx, meshBudgetPx} = this.numbers;
        this.setEye(view, eye, source, byDepth ? meshBudgetPx : budgetPx);
        this.setBlock(0, gridBlock(source.info.camera));
        if (byDepth)
            this.drawMesh(source, view, targets);
        picture.target.bind();
        this.programs[byDepth ? "byDepth" : "byDirection"].use({
            source_colour: source.colour, source_depth: source.distances, eye_depth: targets.found,
            inverse_depth_scale: 1,
        }).drawScreen();
        return byDepth;
    }

    /// The picture of one of so many eyes, in targets.shown[number].
    drawEye(view, eye, number, eyes) {
        const {gl, programs} = this, targets = this.targetsOf(view, eyes);
        gl.bindVertexArray(this.empty);
        const [source] = this.sources;
        let picture = targets.pictures[0];
        const byDepth = this.reproject(source, view, eye, targets, picture);
        if (this.hasWindow) {
            const [own, base, both] = targets.pictures;
            this.reproject(this.main, view, eye, targets, base);
            this.setBlock(0, gridBlock(source.info.camera));
            both.target.bind();
            programs.aroundWindow.use({
                eye_colour: own.colour, eye_origin: own.origin, eye_depth: own.depth, base_colour: base.colour,
                base_origin: base.origin, base_depth: base.depth, inverse_depth_scale: byDepth ? 1 : 0,
            }).drawScreen();
            picture = both;
        }
        this.setEye(view, eye, source, this.numbers.budgetPx);
        this.fill(view, picture, targets, number, byDepth);
        return targets.shown[number];
    }

    /// The pass `pushpull`.
    fill(view, picture, targets, number, byDepth) {
        const {gl, programs} = this, {levels} = targets;
        const own = {eye_colour: picture.colour, eye_origin: picture.origin, eye_depth: picture.depth,
                     inverse_depth_scale: byDepth ? 1 : 0, tolerance: Math.sin(this.numbers.budgetPx / view.focal)};
        if (byDepth) {
            targets.gapTarget.bind();
            programs.gapDepth.use(own).drawScreen();
            own.eye_depth = targets.gapDepth;
        }
        targets.squareTargets[0].bind();
        programs.gapSquares.use(own).drawScreen();
        targets.squareTargets[1].bind();
        programs.squaresBeside.use({squares: targets.squares[0]}).drawScreen();
        levels.forEach((level, i) => {
            level.pulled.bind();
            if (i === 0)
                programs.pullPixels.use({...own, squares: targets.squares[1]}).drawScreen();
            else
                programs.pull.use({finer_layers: levels[i - 1].layers[0], tolerance: own.tolerance,
                                   finer: [levels[i - 1].columns, levels[i - 1].rows]}).drawScreen();
        });
        // The last level has nothing above it.
        const coarser = i => ({coarser: [levels[i].columns, levels[i].rows, 0],
                               coarser_layers: levels[i].layers[i === levels.length - 1 ? 0 : 1]});
        for (let i = levels.length - 2; i >= 0; --i) {
            levels[i].pushed.bind();
            const level = {pulled_layers: levels[i].layers[0], tolerance: own.tolerance, ...coarser(i + 1)};
            programs.push.use(level).drawScreen();
        }
        targets.showing[number].bind();
        programs.pushPixels.use({...own, ...coarser(0)}).drawScreen();
        gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    }

    /// Eyes' pictures onto part of a framebuffer: {left, bottom, width, height}.
    show(framebuffer, place, leftEye, rightEye, anaglyph, fading) {
        const {gl, programs, numbers} = this;
        gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
        gl.bindVertexArray(this.empty);
        gl.viewport(place.left, place.bottom, place.width, place.height);
        programs.show.use({
            left_eye: leftEye, right_eye: rightEye, layout_of: anaglyph ? 1 : 0, from_left: numbers.fromLeft, fading,
            from_right: numbers.fromRight, place: [place.left, place.bottom, place.width, place.height],
        }).drawScreen();
    }

    /// RGBA of a shown eye, from the upper row down.
    read(number) {
        const {gl} = this, {showing} = this.current, target = showing[number];
        const pixels = new Uint8Array(4 * target.width * target.height);
        target.bind();
        gl.readPixels(0, 0, target.width, target.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
        gl.bindFramebuffer(gl.FRAMEBUFFER, null);
        return pixels;
    }
}
