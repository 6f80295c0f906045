// Around which head the viewer's turns and moves: the same rules as FollowedHead and Presenter::lead in C++.
const mostSent = 4096;     // two minutes of them

/// Poses travel unchanged, but for what rounding does: 1e-9 m, and as much of a unit quaternion of either sign.
function isSame(a, b) {
    const apart = (p, q, sign) => Math.hypot(...p.map((number, i) => number - sign * q[i]));
    return apart(a.position, b.position, 1) <= 1e-9 &&
        Math.min(apart(a.orientation, b.orientation, 1), apart(a.orientation, b.orientation, -1)) <= 1e-9;
}

function keep(heads, head) {
    heads.push(head);
    if (heads.length > mostSent)
        heads.shift();
}

export class FollowedHead {
    constructor() {
        this.around = null;
        this.isFollowed = false;  // what is shown was rendered for a head that was sent
        this.heads = [];
        this.looks = [];          // sent as where the head looks alone: older servers render from it all the same
        this.frame = null;
    }

    /// A frame is on show. One that was rendered for this viewer's own head moves nothing.
    show(frame) {
        if (frame === this.frame)
            return;
        this.frame = frame;
        const {head} = frame.info;
        this.isFollowed = this.heads.some(sent => isSame(sent, head));
        if (!this.isFollowed && !this.looks.some(look => isSame(look, head)))
            this.around = head;
    }

    sent(head) {
        keep(this.heads, head);
    }

    looked(head) {
        if (!isSame(head, this.around))
            keep(this.looks, head);
    }
}
