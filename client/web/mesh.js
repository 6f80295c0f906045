// The adaptive mesh of a source's depth, by the rules of client/warp/mesh.h: cells as large as keep w = B / (r - B) within
// a tolerance, cut where w jumps. Points are (q, k): q / k in the source's axes, k = 0 at infinity.
import {agree_inverse, are_joined, column_over_pole, column_round, row_over_pole} from "./formulas.js";
import {gridOf} from "./grid.js";
import {MeshArrays} from "./mesh_arrays.js";

const side = 32, before = 2, after = 3, stride = before + side + after, levels = 5;
/// Blocks farther than this from what a view shows are not built, beyond what parallax may bring into it.
const margin = 20 * Math.PI / 180;

const at = (x, y) => (y + before) * stride + x + before;

/// Corners of a block's cells, and its cells: x, y, side, and 0 where not all of its corners are joined.
class Block {
    constructor() {
        this.corners = new Uint8Array((side + 1) * (side + 1));
        this.cells = [];
        this.right = new Uint8Array(stride * stride);
        this.down = new Uint8Array(stride * stride);
    }

    isCorner(x, y) {
        return this.corners[y * (side + 1) + x] !== 0;
    }
}

export class MeshBuilder {
    constructor() {
        this.qx = new Float32Array(stride * stride);
        this.qy = new Float32Array(stride * stride);
        this.qz = new Float32Array(stride * stride);
        this.k = new Float32Array(stride * stride);
        this.flat = Array.from({length: levels + 1}, () => new Uint8Array(side * side));
        this.numbers = new Int32Array(stride * stride);
        this.pool = [];
    }

    /// distances of the camera's samples; `bound`: {boxRadius, tolerance, share}; `seen`: {directions, halfAngle,
    /// distance} of the eyes in the source's axes. Gives {points, indices}.
    build(camera, distances, bound, seen) {
        this.grid = gridOf(camera);
        this.distances = distances;
        this.bound = bound;
        this.setAngles(camera);
        const {width, height, closes} = this.grid;
        this.firstColumn = closes ? 0 : -1;
        this.columns = Math.ceil((width - this.firstColumn) / side);
        this.rows = Math.ceil((height + 1) / side);
        this.blocks = new Array(this.columns * this.rows);
        this.arrays = new MeshArrays();
        let used = 0;
        for (let i = 0; i < this.blocks.length; ++i) {
            if (!this.mayShow(i, seen))
                continue;
            this.blocks[i] = this.pool[used] ??= new Block();
            ++used;
            this.load(i);
            this.findCells(this.blocks[i]);
        }
        for (let i = 0; i < this.blocks.length; ++i)
            if (this.blocks[i]) {
                this.load(i);
                this.addTriangles(i);
            }
        return this.arrays.used;
    }

    /// Of columns and rows from -1 on: sines and cosines of a sphere's, slopes of a flat picture's.
    setAngles(camera) {
        const {width, height, isSphere, focal} = this.grid;
        const place = (i, n) => Math.min(Math.max(i + 0.5, 0), n);
        const table = (count, of) => Float32Array.from({length: count + 2}, (_, i) => of(place(i - 1, count)));
        if (!isSphere) {
            this.columnA = table(width, u => (u - 0.5 * width) / focal);
            this.rowA = table(height, v => (0.5 * height - v) / focal);
            return;
        }
        const [left, right] = camera.longitudes, [low, high] = camera.latitudes;
        const longitude = u => left + u * (right - left) / width, latitude = v => high - v * (high - low) / height;
        this.columnA = table(width, u => Math.sin(longitude(u)));
        this.columnB = table(width, u => Math.cos(longitude(u)));
        this.rowA = table(height, v => Math.sin(latitude(v)));
        this.rowB = table(height, v => Math.cos(latitude(v)));
    }

    origin(i) {
        return [this.firstColumn + (i % this.columns) * side, -1 + Math.floor(i / this.columns) * side];
    }

    mayShow(i, seen) {
        const [x0, y0] = this.origin(i), {width, height} = this.grid;
        const x1 = Math.min(x0 + side, width), y1 = Math.min(y0 + side, height);
        let nearest = Infinity;
        for (let y = Math.max(y0, 0); y < y1; ++y)
            for (let j = y * width + Math.max(x0, 0), end = y * width + x1; j < end; ++j)
                if (this.distances[j] < nearest)
                    nearest = this.distances[j];
        const axis = this.direction((x0 + x1) >> 1, (y0 + y1) >> 1);
        const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let least = 1;
        for (const x of [x0, x1])
            for (const y of [y0, y1])
                least = Math.min(least, dot(axis, this.direction(x, y)));
        const reach = Math.acos(Math.max(least, -1)) * 1.1 + Math.asin(Math.min(1, seen.distance / nearest)) + margin +
            seen.halfAngle;
        return seen.directions.some(gaze => Math.acos(Math.min(Math.max(dot(gaze, axis), -1), 1)) <= reach);
    }

    /// Brings coordinates of a sphere back into the picture.
    wrap(x, y) {
        const {width, closes} = this.grid;
        x = column_round(this.grid, column_over_pole(this.grid, x, y));
        return [closes && x >= width ? x % width : x, row_over_pole(this.grid, y)];
    }

    direction(x, y) {
        const {width, height, isSphere} = this.grid;
        [x, y] = this.wrap(x, y);
        const column = Math.min(Math.max(x, -1), width) + 1, row = Math.min(Math.max(y, -1), height) + 1;
        const a = this.columnA[column], p = this.rowA[row];
        if (!isSphere) {
            const scale = 1 / Math.sqrt(1 + a * a + p * p);
            return [a * scale, p * scale, -scale];
        }
        const c = this.rowB[row];
        return [c * a, p, -c * this.columnB[column]];
    }

    inverseOf(x, y) {
        const distance = this.distances[y * this.grid.width + x];
        return distance > 0 ? 1 / distance : NaN;
    }

    /// On the picture's edge, half a pixel beyond a sample: where its plane leads. NaN further out.
    inverseAt(x, y) {
        const {width, height} = this.grid;
        [x, y] = this.wrap(x, y);
        if (x >= 0 && y >= 0 && x < width && y < height)
            return this.inverseOf(x, y);
        if (x < -1 || y < -1 || x > width || y > height)
            return NaN;
        const clamp = (value, most) => Math.min(Math.max(value, 0), most);
        const innerX = clamp(x, width - 1), innerY = clamp(y, height - 1);
        const behind = this.inverseOf(clamp(2 * innerX - x, width - 1), clamp(2 * innerY - y, height - 1));
        const k = 1.5 * this.inverseOf(innerX, innerY) - 0.5 * behind;
        return k < 0 ? 0 : k;
    }

    load(i) {
        const [x0, y0] = this.origin(i), {width, height, isSphere} = this.grid;
        const {qx, qy, qz, k} = this;
        this.x0 = x0;
        this.y0 = y0;
        this.cellColumns = Math.min(side, width - x0);
        this.cellRows = Math.min(side, height - y0);
        const columnsInside = x0 >= before && x0 + side + after <= width;
        for (let y = -before; y < side + after; ++y) {
            const row = y0 + y;
            let j = at(-before, y);
            if (!columnsInside || row < 0 || row >= height || !isSphere) {
                for (let x = x0 - before; x < x0 + side + after; ++x, ++j) {
                    [qx[j], qy[j], qz[j]] = this.direction(x, row);
                    k[j] = this.inverseAt(x, row);
                }
                continue;
            }
            const c = this.rowB[row + 1], p = this.rowA[row + 1];
            for (let x = x0 - before; x < x0 + side + after; ++x, ++j) {
                qx[j] = c * this.columnA[x + 1];
                qy[j] = p;
                qz[j] = -c * this.columnB[x + 1];
                const distance = this.distances[row * width + x];
                k[j] = distance > 0 ? 1 / distance : NaN;
            }
        }
    }

    findJoined({right, down}) {
        const {k} = this, {boxRadius, tolerance} = this.bound, count = stride * stride;
        for (let i = 1; i < count - 2; ++i)
            right[i] = are_joined(k[i - 1], k[i], k[i + 1], k[i + 2], boxRadius, tolerance) ? 1 : 0;
        for (let i = stride; i < count - 2 * stride; ++i)
            down[i] = are_joined(k[i - stride], k[i], k[i + stride], k[i + 2 * stride], boxRadius, tolerance) ? 1 : 0;
    }

    findCells(block) {
        this.findJoined(block);
        const {right, down} = block, {cellColumns, cellRows, flat} = this;
        for (const level of flat)
            level.fill(0);
        for (let y = 0; y < cellRows; ++y)
            for (let x = 0; x < cellColumns; ++x) {
                const i = at(x, y);
                flat[0][y * side + x] = right[i] & right[i + stride] & down[i] & down[i + 1];
            }
        for (let level = 1; level <= levels; ++level)
            this.findFlat(level);
        block.corners.fill(0);
        block.cells.length = 0;
        this.collect(block, levels, 0, 0);
    }

    findFlat(level) {
        const size = 1 << level, half = size >> 1, below = this.flat[level - 1], shift = level - 1;
        for (let y = 0; y + size <= this.cellRows; y += size)
            for (let x = 0; x + size <= this.cellColumns; x += size) {
                const i = (y >> shift) * side + (x >> shift), j = ((y + half) >> shift) * side + (x >> shift);
                if (below[i] & below[i + 1] & below[j] & below[j + 1] && this.holds(x, y, size))
                    this.flat[level][(y >> level) * side + (x >> level)] = 1;
            }
    }

    /// m of 1/r = m . q through three points (mesh.cpp, plane_through).
    plane(a, b, c) {
        const {qx, qy, qz, k} = this;
        const ox = qx[a], oy = qy[a], oz = qz[a], square = ox * ox + oy * oy + oz * oz, ka = k[a] / square;
        const bx = qx[b] - ox, by = qy[b] - oy, bz = qz[b] - oz, cx = qx[c] - ox, cy = qy[c] - oy, cz = qz[c] - oz;
        const alongB = (bx * ox + by * oy + bz * oz) / square, alongC = (cx * ox + cy * oy + cz * oz) / square;
        const ux = bx - alongB * ox, uy = by - alongB * oy, uz = bz - alongB * oz;
        const vx = cx - alongC * ox, vy = cy - alongC * oy, vz = cz - alongC * oz;
        const atU = k[b] - k[a] - ka * alongB * square, atV = k[c] - k[a] - ka * alongC * square;
        const uu = ux * ux + uy * uy + uz * uz, vv = vx * vx + vy * vy + vz * vz, uv = ux * vx + uy * vy + uz * vz;
        const determinant = uu * vv - uv * uv;
        const s = (atU * vv - atV * uv) / determinant, t = (atV * uu - atU * uv) / determinant;
        return [ka * ox + s * ux + t * vx, ka * oy + s * uy + t * vy, ka * oz + s * uz + t * vz];
    }

    /// Both triangles of a cell, split from its first corner to the opposite one.
    holds(x, y, size) {
        const a = at(x, y), b = at(x + size, y), c = at(x, y + size), d = at(x + size, y + size);
        const upper = this.plane(a, b, d), lower = this.plane(a, d, c);
        for (let j = 0; j <= size; ++j) {
            const row = a + j * stride;
            if (!this.rowHolds(row, row + j, lower) || !this.rowHolds(row + j, row + size, upper))
                return false;
        }
        return true;
    }

    rowHolds(first, last, [mx, my, mz]) {
        const {qx, qy, qz, k} = this, {boxRadius, share} = this.bound;
        for (let i = first; i <= last; ++i)
            if (!agree_inverse(mx * qx[i] + my * qy[i] + mz * qz[i], k[i], boxRadius, share))
                return false;
        return true;
    }

    collect(block, level, x, y) {
        if (x >= this.cellColumns || y >= this.cellRows)
            return;
        const size = 1 << level, isFlat = this.flat[level][(y >> level) * side + (x >> level)];
        if (!isFlat && level > 0) {
            const half = size >> 1;
            for (const [dx, dy] of [[0, 0], [half, 0], [0, half], [half, half]])
                this.collect(block, level - 1, x + dx, y + dy);
            return;
        }
        block.cells.push(x, y, size, isFlat);
        for (const [cx, cy] of [[x, y], [x + size, y], [x, y + size], [x + size, y + size]])
            block.corners[cy * (side + 1) + cx] = 1;
    }

    neighbours(i) {
        const {closes} = this.grid, x = i % this.columns, y = Math.floor(i / this.columns);
        const left = x > 0 ? x - 1 : closes ? this.columns - 1 : -1;
        const right = x + 1 < this.columns ? x + 1 : closes ? 0 : -1;
        const of = (column, row) =>
            column < 0 || row < 0 || row >= this.rows ? null : this.blocks[row * this.columns + column];
        return {left: of(left, y), right: of(right, y), above: of(x, y - 1), below: of(x, y + 1),
                leftColumns: Math.min(side, this.grid.width - this.firstColumn - left * side)};
    }

    isCorner(x, y) {
        const {block, beside} = this;
        return block.isCorner(x, y) || (x === 0 && beside.left?.isCorner(beside.leftColumns, y)) ||
            (x === this.cellColumns && beside.right?.isCorner(0, y)) || (y === 0 && beside.above?.isCorner(x, side)) ||
            (y === this.cellRows && beside.below?.isCorner(x, 0));
    }

    addTriangles(i) {
        this.block = this.blocks[i];
        this.beside = this.neighbours(i);
        this.numbers.fill(-1);
        const {cells} = this.block;
        for (let j = 0; j < cells.length; j += 4) {
            // Cells over a pole are turned over: which way round they come says nothing.
            this.eitherWay = this.y0 + cells[j + 1] < 0;
            if (cells[j + 3])
                this.addWhole(cells[j], cells[j + 1], cells[j + 2]);
            else
                this.addCut(cells[j], cells[j + 1]);
        }
    }

    corner(x, y) {
        const i = at(x, y);
        if (this.numbers[i] < 0)
            this.numbers[i] = this.arrays.addPoint(this.qx[i], this.qy[i], this.qz[i], this.k[i]);
        return this.numbers[i];
    }

    add(a, b, c) {
        this.arrays.addTriangle(a, b, c);
        if (this.eitherWay)
            this.arrays.addTriangle(a, c, b);
    }

    addWhole(x, y, size) {
        const border = [];
        const look = (cx, cy) => {
            if (this.isCorner(cx, cy))
                border.push(this.corner(cx, cy));
        };
        for (let i = 0; i < size; ++i)
            look(x + i, y);
        for (let i = 0; i < size; ++i)
            look(x + size, y + i);
        for (let i = size; i > 0; --i)
            look(x + i, y + size);
        for (let i = size; i > 0; --i)
            look(x, y + i);
        if (size === 1 || border.length <= 4) {
            const a = this.corner(x, y), d = this.corner(x + size, y + size);
            this.add(a, this.corner(x + size, y), d);
            this.add(a, d, this.corner(x, y + size));
            return;
        }
        const centre = this.corner(x + (size >> 1), y + (size >> 1));
        for (let i = 0; i < border.length; ++i)
            this.add(centre, border[i], border[(i + 1) % border.length]);
    }

    /// Each corner has the quarter of the cell next to it; what is joined meets in common points, what is not goes on
    /// along its own plane up to the middle and ends there.
    addCut(x, y) {
        const {qx, qy, qz, k} = this, {right, down} = this.block;
        const places = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]], first = at(x, y);
        const joined = [right[first], down[first + 1], right[first + stride], down[first]];
        const part = [0, 1, 2, 3];
        for (let i = 0; i < 4; ++i)
            if (joined[i]) {
                const from = part[(i + 1) % 4], to = part[i];
                part.forEach((of, j) => part[j] = of === from ? to : of);
            }
        const atCentre = places.map(([px, py]) => this.continued(px, py, px === x ? 0.5 : -0.5, py === y ? 0.5 : -0.5));
        const mean = [0, 0, 0];
        for (const [px, py] of places) {
            const i = at(px, py);
            mean[0] += 0.25 * qx[i];
            mean[1] += 0.25 * qy[i];
            mean[2] += 0.25 * qz[i];
        }
        for (let i = 0; i < 4; ++i) {
            const [px, py] = places[i];
            if (!(k[at(px, py)] >= 0))
                continue;
            let sum = 0, count = 0;
            for (let j = 0; j < 4; ++j)
                if (part[j] === part[i]) {
                    sum += atCentre[j];
                    ++count;
                }
            const here = this.corner(px, py), centre = this.arrays.addPoint(...mean, Math.max(sum / count, 0));
            const next = this.towards(places[i], places[(i + 1) % 4], joined[i]);
            const last = this.towards(places[i], places[(i + 3) % 4], joined[(i + 3) % 4]);
            this.add(here, next, centre);
            this.add(here, centre, last);
        }
    }

    towards([x, y], [toX, toY], isJoined) {
        const {qx, qy, qz, k} = this, i = at(x, y), j = at(toX, toY);
        const half = isJoined
            ? 0.5 * (k[i] + k[j])
            : Math.max(this.continued(x, y, 0.5 * (toX - x), 0.5 * (toY - y)), 0);
        return this.arrays.addPoint(0.5 * (qx[i] + qx[j]), 0.5 * (qy[i] + qy[j]), 0.5 * (qz[i] + qz[j]), half);
    }

    /// The inverse distance that a point's own surface has a little beside it.
    continued(x, y, dx, dy) {
        const {k} = this, {right, down} = this.block, i = at(x, y);
        const slope = (joined, step, towards) => {
            const isBefore = joined[i - step], isAfter = joined[i];
            if (isAfter && (towards > 0 || !isBefore))
                return k[i + step] - k[i];
            return isBefore ? k[i] - k[i - step] : 0;
        };
        return k[i] + dx * slope(right, 1, dx) + dy * slope(down, stride, dy);
    }
}
