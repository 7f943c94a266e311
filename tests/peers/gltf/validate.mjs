// SPDX-License-Identifier: Apache-2.0
// validate.mjs FILE...: what Khronos' validator finds in files of glTF. Exit status 1: an error or a warning.
import {readFileSync} from "node:fs";
import validator from "gltf-validator";

for (const file of process.argv.slice(2)) {
  const {issues, info} = await validator.validateBytes(new Uint8Array(readFileSync(file)));
  console.log(`${file}: ${issues.numErrors} errors, ${issues.numWarnings} warnings, ${info.totalTriangleCount} triangles`);
  if (!issues.numErrors && !issues.numWarnings) continue;
  for (const {code, message, pointer} of issues.messages) console.log(`  ${code} ${pointer}: ${message}`);
  process.exitCode = 1;
}
