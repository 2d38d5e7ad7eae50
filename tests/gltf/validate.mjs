// Validates glTF files with the Khronos validator, and fails if one has errors.
//
//   node validate.mjs FILE...
import { readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';

import validator from 'gltf-validator';

let failed = false;
for (const file of process.argv.slice(2)) {
    const options = { externalResourceFunction: (uri) => Promise.resolve(new Uint8Array(readFileSync(join(dirname(file), uri)))) };
    const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(file)), options);
    const errors = issues.messages.filter(({ severity }) => severity < 2);
    console.log(`${file}: ${issues.numErrors} errors, ${issues.numWarnings} warnings`);
    for (const { code, message, pointer } of errors) console.log(`  ${code} ${pointer}: ${message}`);
    failed ||= issues.numErrors > 0;
}
process.exit(failed ? 1 : 0);
