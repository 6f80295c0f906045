// The page's side of worker.js.
import {StreamError} from "./bytes.js";

export class Helper {
    constructor(text) {
        this.worker = new Worker(URL.createObjectURL(new Blob([text], {type: "text/javascript"})));
        this.waiting = new Map();
        this.number = 0;
        this.worker.onmessage = ({data}) => {
            const {resolve, reject} = this.waiting.get(data.number);
            this.waiting.delete(data.number);
            if (data.problem)
                reject(new StreamError(data.problem));
            else
                resolve(data.answer);
        };
        this.worker.onerror = event => {
            const problem = new Error(`beside the page: ${event.message ?? "the browser has ended it"}`);
            for (const {reject} of this.waiting.values())
                reject(problem);
            this.waiting.clear();
        };
    }

    ask(order, words) {
        const number = ++this.number;
        return new Promise((resolve, reject) => {
            this.waiting.set(number, {resolve, reject});
            this.worker.postMessage({number, order, ...words});
        });
    }
}
