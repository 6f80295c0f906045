// Beside the page: depth tracks into distances, and these into meshes. Orders come in turn; an answer has its number.
import {unpackDepth} from "./depth.js";
import {MeshBuilder} from "./mesh.js";

const builder = new MeshBuilder();
/// Of pictures whose mesh may be asked for again: {camera, distances} by key.
const kept = new Map();

const orders = {
    depth({key, picture, info, luma}) {
        const distances = unpackDepth(picture, info, luma);
        kept.set(key, {camera: info.camera, distances});
        return {distances: distances.slice()};
    },
    mesh({key, bound, seen}) {
        const {camera, distances} = kept.get(key);
        return builder.build(camera, distances, bound, seen);
    },
    forget({key}) {
        kept.delete(key);
        return {};
    },
};

self.onmessage = ({data}) => {
    try {
        const answer = orders[data.order](data);
        const buffers = Object.values(answer).map(array => array.buffer);
        self.postMessage({number: data.number, answer}, buffers);
    } catch (error) {
        self.postMessage({number: data.number, problem: error.message});
    }
};
