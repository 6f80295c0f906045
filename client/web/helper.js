// The page's side of worker.js.
import {StreamError} from "./bytes.js";

export class Helper {
    constructor(text) {
        this.worker = new Worker(URL.createObjectURL(new Blob([text], {type: "text/javascript"})));
        this.waiting = new Map();
        this.number = 0;
        this.worker.onmessage = ({data}) => {
            const {resolve, reject} = this.waiting.get(data.number) ?? {};
            if (!this.waiting.delete(data.number))
                return;
            if (data.problem)
                reject(new StreamError(data.problem));
            else
                resolve(data.answer);
        };
        this.worker.onerror = event => {
            this.problem = new StreamError(`the page's worker: ${event.message || "the browser has ended it"}`);
            for (const {reject} of this.waiting.values())
                reject(this.problem);
            this.waiting.clear();
        };
    }

    ask(order, words) {
        if (this.problem)
            return Promise.reject(this.problem);
        const number = ++this.number;
        return new Promise((resolve, reject) => {
            this.waiting.set(number, {resolve, reject});
            this.worker.postMessage({number, order, ...words});
        });
    }
}
