// Bundles the JavaScript of the pages with esbuild; `--check` compares it with what is committed.
//
// three.js stands in a bundle of its own, `vendor.js`, which changes with its version alone; the
// pages' own code stays readable in `report.js`.

import { createHash } from 'node:crypto';
import { readFileSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import * as esbuild from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));
const target = join(here, '..', 'dolfingrip', 'report', 'page', 'bundle');
const PAGES = ['report', 'explore'];
const shared = {
  bundle: true,
  charset: 'utf8',
  format: 'iife',
  legalComments: 'none', // the whole licences stand in each page
  platform: 'browser',
  target: 'es2022',
  write: false,
};

async function built(entry, options) {
  const { outputFiles } = await esbuild.build({
    ...shared,
    entryPoints: [join(here, 'src', entry)],
    ...options,
  });
  return outputFiles[0].text;
}

const packageOf = (name) => join(here, 'node_modules', name);
const version = (name) => JSON.parse(readFileSync(join(packageOf(name), 'package.json'))).version;
const sha256 = (text) => createHash('sha256').update(text).digest('hex');

const files = {
  'vendor.js': await built('three.js', { minify: true, globalName: 'DolfingripThree' }),
};
for (const page of PAGES) {
  files[`${page}.js`] = await built(`${page}.js`, {});
  files[`${page}.css`] = readFileSync(join(here, 'src', `${page}.css`), 'utf8');
}
files['gpl-3.0.txt'] = readFileSync(join(here, '..', 'LICENSE'), 'utf8');
const licence = readFileSync(join(packageOf('three'), 'LICENSE'), 'utf8');
files['bundle.json'] = `${JSON.stringify(
  {
    esbuild: version('esbuild'),
    parts: [
      {
        file: 'vendor.js',
        name: 'three.js',
        version: version('three'),
        licence: 'MIT',
        licence_text: licence,
        sha256: sha256(files['vendor.js']),
      },
      ...PAGES.map((page) => ({
        file: `${page}.js`,
        name: `dolfingrip, ${page} page`,
        version: null,
        licence: 'GPL-3.0-or-later',
        licence_text: null,
        sha256: sha256(files[`${page}.js`]),
      })),
    ],
  },
  null,
  1,
)}\n`;

const check = process.argv.includes('--check');
let differ = 0;
for (const [name, text] of Object.entries(files)) {
  const file = join(target, name);
  if (!check) {
    writeFileSync(file, text);
    console.log(`wrote ${file} (${(text.length / 1000).toFixed(0)} kB)`);
    continue;
  }
  let there = null;
  try {
    there = readFileSync(file, 'utf8');
  } catch {
    // missing is another way to differ
  }
  if (there === text) continue;
  differ += 1;
  console.error(`${file} is not what the sources in web/ build; scripts/bundle writes it`);
}
if (check && !differ) console.log(`${Object.keys(files).length} files are what web/ builds`);
process.exit(differ ? 1 : 0);
