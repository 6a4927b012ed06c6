// Typeset the equations of a page ($...$ and $$...$$) with the MathJax beside this file; pages without any do not load it.
const folder = document.currentScript.src.replace(/[^/]*$/, "");

window.MathJax = {
  tex: { inlineMath: [["\\(", "\\)"]], displayMath: [["\\[", "\\]"]] },
  svg: { scale: 0.88 },
  options: { processHtmlClass: "arithmatex", ignoreHtmlClass: ".*", enableMenu: false },
};

function typeset() {
  if (!document.querySelector(".arithmatex")) return;
  if (window.MathJax.typesetPromise) {
    window.MathJax.typesetPromise();
  } else if (!document.getElementById("mathjax")) {
    const script = document.createElement("script");
    script.id = "mathjax";
    script.src = folder + "mathjax/tex-svg.js";
    document.head.append(script);
  }
}

document.addEventListener("DOMContentLoaded", typeset);
