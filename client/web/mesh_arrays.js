// Points and triangles of a mesh that is being made, in arrays that grow.

export class MeshArrays {
    constructor() {
        this.points = new Float32Array(1 << 16);
        this.indices = new Uint32Array(1 << 16);
        this.pointCount = this.indexCount = 0;
    }

    /// Its number.
    addPoint(x, y, z, k) {
        if (4 * this.pointCount + 4 > this.points.length) {
            const room = new Float32Array(2 * this.points.length);
            room.set(this.points);
            this.points = room;
        }
        this.points.set([x, y, z, k], 4 * this.pointCount);
        return this.pointCount++;
    }

    addTriangle(a, b, c) {
        if (this.indexCount + 3 > this.indices.length) {
            const room = new Uint32Array(2 * this.indices.length);
            room.set(this.indices);
            this.indices = room;
        }
        this.indices[this.indexCount++] = a;
        this.indices[this.indexCount++] = b;
        this.indices[this.indexCount++] = c;
    }

    get used() {
        return {points: this.points.slice(0, 4 * this.pointCount), indices: this.indices.slice(0, this.indexCount)};
    }
}
