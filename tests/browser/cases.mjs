// The cases for the browser, a function each. A case throws when it fails.

export * from "./clarity.mjs";
export * from "./controller.mjs";
export * from "./driving.mjs";
export * from "./faults.mjs";
export * from "./hands.mjs";
export * from "./history.mjs";
export * from "./layout.mjs";
export * from "./login.mjs";
export * from "./looking.mjs";
export { screenshots } from "./screenshots.mjs";
