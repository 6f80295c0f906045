// Around which head the viewer's turns and moves: the same rules as FollowedHead and Presenter::lead in C++.
const mostSent = 4096;     // two minutes of them
const samePlace = 1e-9;    // metres: positions travel unchanged

export class FollowedHead {
    constructor() {
        this.around = null;
        this.isFollowed = false;  // what is shown was rendered for a head that was sent
        this.places = [];
        this.frame = null;
    }

    /// A frame is on show. One that was rendered for this viewer's own head moves nothing.
    show(frame) {
        if (frame === this.frame)
            return;
        this.frame = frame;
        const {head} = frame.info;
        this.isFollowed = this.places.some(
            place => Math.hypot(...place.map((metres, i) => metres - head.position[i])) <= samePlace);
        if (!this.isFollowed)
            this.around = head;
    }

    sent(head) {
        this.places.push(head.position);
        if (this.places.length > mostSent)
            this.places.shift();
    }
}
