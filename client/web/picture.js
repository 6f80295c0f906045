// The frame on show with its meshes, which the helper makes for where eyes look.

export class ShownFrame {
    constructor(renderer, helper, onProblem) {
        this.renderer = renderer;
        this.helper = helper;
        this.onProblem = onProblem;
        this.frame = null;
        this.isMaking = false;
        this.made = {};  // by role, of the frame's meshes
        this.changes = 0;
    }

    rolesOf(frame) {
        return ["main", "window"].filter(role => frame[role]);
    }

    /// Brings the frame, or what its meshes lack for these eyes, on show when it is ready.
    want(frame, view, eyes) {
        if (!frame || this.isMaking)
            return;
        const isNew = frame !== this.frame;
        const lacks = this.rolesOf(frame).some(
            role => this.renderer.missingMesh(frame[role], isNew ? null : this.made[role], view, eyes, false));
        if (isNew || lacks)
            this.show(frame, view, eyes, false).catch(this.onProblem);
    }

    /// Another stream begins.
    clear() {
        this.frame = this.coming = null;
        this.made = {};
    }

    async show(frame, view, eyes, exact) {
        this.renderer.checkSizes(frame);
        this.isMaking = true;
        this.coming = frame;
        try {
            const isNew = frame !== this.frame;
            const meshes = await Promise.all(this.rolesOf(frame).map(async role => {
                const made = this.renderer.missingMesh(frame[role], isNew ? null : this.made[role], view, eyes, exact);
                return made && {role, made, mesh: await this.helper.ask("mesh", {key: frame[role].key, ...made})};
            }));
            if (this.coming !== frame)
                return;
            if (isNew) {
                this.renderer.setFrame(frame);
                this.made = {};
                this.frame = frame;
                frame.wasShown = true;
            }
            for (const each of meshes.filter(Boolean)) {
                this.renderer[each.role].setMesh(each.mesh);
                this.made[each.role] = each.made;
            }
            ++this.changes;
        } finally {
            this.isMaking = false;
            this.coming = null;
        }
    }

    /// Frames that must not be forgotten.
    get kept() {
        return [this.frame, this.coming];
    }
}
