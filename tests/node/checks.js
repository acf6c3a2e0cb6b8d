// The common functions of the scripts of this folder.
"use strict";

const assert = require("assert");

exports.equal = (what, found, expected) => {
    assert.deepStrictEqual(found, expected, what);
    console.log(`ok  ${what}`);
};

/** The promise fails with a general status. */
exports.refused = async (what, promise, general) => {
    const why = await promise.then(() => null, (error) => error);
    assert.strictEqual(why && why.generalStatusCode, general, `${what}: ${JSON.stringify(why)}`);
    console.log(`ok  ${what}`);
};

/** Runs a script to its end, which must come before its caller loses patience. */
exports.run = (name, main) => {
    const failed = (why) => {
        console.error("FAILED", why);
        process.exit(1);
    };
    setTimeout(() => failed("has not ended within 110 s"), 110000).unref();
    main().then(() => {
        console.log(`${name}: all as expected`);
        process.exit(0);
    }, failed);
};
