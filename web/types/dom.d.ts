// The types of `js/dom.js`: what an element is made from, and which element a tag makes.

/** What stands in an element: strings, nodes and lists of them; `null`, `undefined` and `false` are left out. */
export type Child = Node | string | null | undefined | false | Child[];

/** The listeners of an element by the names of their attributes: `onclick`, `oninput`. */
export type Listeners = { [K in keyof HTMLElementEventMap as `on${K}`]?: (event: HTMLElementEventMap[K]) => unknown };

/** The attributes of an element; `true` is one without a value, and `null`, `false` and `undefined` leave it out. */
export type Attributes = Listeners & { [name: string]: unknown };

type TagOf<Spec extends string> = Spec extends `${infer Tag}.${string}` ? Tag : Spec;

/** The element of a tag with classes: `"button.primary"` makes an `HTMLButtonElement`. */
export type ElementOf<Spec extends string> = TagOf<Spec> extends keyof HTMLElementTagNameMap ? HTMLElementTagNameMap[TagOf<Spec>] : HTMLElement;
