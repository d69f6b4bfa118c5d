// Packs the extension:  pack.mjs CDB SOURCE STAGE
// STAGE gets the contents of the .vsix, which is a zip of it. Run where the packages are installed.
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { build } from "esbuild";

const [cdb, source, stage] = process.argv.slice(2);
const extension = join(stage, "extension");
mkdirSync(extension, { recursive: true });
const manifest = JSON.parse(readFileSync(join(source, "package.json"), "utf8"));
await build({
  entryPoints: [join(source, "extension.js")], outfile: join(extension, "extension.js"), bundle: true,
  platform: "node", format: "cjs", external: ["vscode"], minify: true, logLevel: "error",
  nodePaths: [join(process.cwd(), "node_modules")],
});
for (const unused of ["dependencies", "devDependencies"]) delete manifest[unused]; // they are in the bundle
writeFileSync(join(extension, "package.json"), JSON.stringify(manifest, null, 2));
copyFileSync(join(source, "language-configuration.json"), join(extension, "language-configuration.json"));
writeFileSync(join(extension, "cdb.tmLanguage.json"), execFileSync(cdb, ["generate", "textmate"]));
writeFileSync(join(stage, "[Content_Types].xml"), `<?xml version="1.0" encoding="utf-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
  <Default Extension=".json" ContentType="application/json"/>
  <Default Extension=".js" ContentType="application/javascript"/>
  <Default Extension=".vsixmanifest" ContentType="text/xml"/>
</Types>
`);
writeFileSync(join(stage, "extension.vsixmanifest"), `<?xml version="1.0" encoding="utf-8"?>
<PackageManifest Version="2.0.0" xmlns="http://schemas.microsoft.com/developer/vsx-schema/2011">
  <Metadata>
    <Identity Language="en-US" Id="${manifest.name}" Version="${manifest.version}" Publisher="${manifest.publisher}"/>
    <DisplayName>${manifest.displayName}</DisplayName>
    <Description xml:space="preserve">${manifest.description}</Description>
    <Properties>
      <Property Id="Microsoft.VisualStudio.Code.Engine" Value="${manifest.engines.vscode}"/>
    </Properties>
  </Metadata>
  <Installation><InstallationTarget Id="Microsoft.VisualStudio.Code"/></Installation>
  <Dependencies/>
  <Assets>
    <Asset Type="Microsoft.VisualStudio.Code.Manifest" Path="extension/package.json" Addressable="true"/>
  </Assets>
</PackageManifest>
`);
